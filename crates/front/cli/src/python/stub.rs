//! The types of the Python functions, for type checkers and editors.

use super::{Function, Group, PLAIN, Section, python_functions, wrapped};
use std::collections::BTreeSet;
use std::fmt::Write;

const WIDTH: usize = 110;
const HEAD: &str = r#""""Types of the verbs as functions. Written by the program from its table of flags; do not edit:
UPDATE_REFERENCE=1 cargo test -p protomer-cli --test documentation
"""

# ruff: noqa: E501
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Literal

import numpy as np
from distributed import Client
from numpy.typing import NDArray

from ._assembly import Assembly
from ._body import Body
from .results import (
"#;

/// The text of `python/protomer/_verbs.pyi`.
pub fn python_stub() -> String {
    let groups = python_functions();
    let mut text = HEAD.to_owned();
    let functions = groups.iter().flat_map(|group| &group.functions);
    let mut classes: BTreeSet<&str> = functions.map(|function| &*function.result).collect();
    classes.insert(PLAIN);
    for class in classes {
        let _ = writeln!(text, "    {class},");
    }
    text.push_str(")\n\n__all__ = [\n");
    for Group { name, .. } in &groups {
        let _ = writeln!(text, "    \"{name}\",");
    }
    text.push_str("]\n");
    for group in &groups {
        write_group(&mut text, group);
    }
    text
}

fn write_group(text: &mut String, group: &Group) {
    if !group.has_methods {
        for function in &group.functions {
            text.push('\n');
            write_function(text, function, "");
        }
        return;
    }
    let class = capitalised(&group.name);
    let _ = writeln!(text, "\nclass _{class}:");
    write_docstring(text, &group.about, "    ");
    for function in &group.functions {
        text.push('\n');
        write_function(text, function, "    ");
    }
    let _ = writeln!(text, "\n{}: _{class}", group.name);
}

fn write_function(text: &mut String, function: &Function, indent: &str) {
    let Function {
        name,
        parameters,
        result,
        about,
        ..
    } = function;
    let _ = writeln!(text, "{indent}def {name}(");
    if !indent.is_empty() {
        let _ = writeln!(text, "{indent}    self,");
    }
    let (places, keywords): (Vec<_>, Vec<_>) = parameters
        .iter()
        .partition(|parameter| parameter.section == Section::Place);
    for place in places {
        let _ = writeln!(text, "{indent}    {},", place.declaration());
    }
    let _ = writeln!(text, "{indent}    *,");
    for keyword in keywords {
        let _ = writeln!(text, "{indent}    {},", keyword.declaration());
    }
    let _ = writeln!(text, "{indent}) -> {result}:");
    write_docstring(text, about, &format!("{indent}    "));
}

fn write_docstring(text: &mut String, about: &str, indent: &str) {
    let about = about.replace('\\', "\\\\").replace("\"\"\"", "'''");
    let lines = wrapped(&about, WIDTH - indent.len() - 6, indent);
    let _ = writeln!(
        text,
        "{indent}\"\"\"{}\"\"\"",
        lines.join("\n").trim_start()
    );
}

fn capitalised(name: &str) -> String {
    let mut letters = name.chars();
    letters.next().map_or(String::new(), |first| {
        first.to_uppercase().chain(letters).collect()
    })
}
