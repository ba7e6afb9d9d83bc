//! Tables that a click on a heading sorts.

use super::html::table;
use protomer_common::page::Program;

/// Style of the headings.
const STYLE: &str = ".sortable th { padding: 0 } .sortable th button { font: inherit; color: inherit; background: none; border: 0; \
                     padding: .3em .6em; cursor: pointer; text-align: inherit }\n.sortable th[aria-sort=ascending] button::after { content: \" \\25B2\" }\n\
                     .sortable th[aria-sort=descending] button::after { content: \" \\25BC\" }\n";

/// A table whose headings are buttons.
pub fn program(columns: &[String], rows: &[Vec<String>]) -> Program {
    Program {
        html: format!("<div class=\"sortable\">\n{}</div>\n", table(columns, rows)),
        style: STYLE.into(),
        library: include_str!("sortable.js"),
        script: "document.querySelectorAll(\".sortable table\").forEach(sortable);\n".into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sortable_table_escapes_its_cells_and_names_its_script() {
        let program = program(&["a<b".into()], &[vec!["1".into()]]);
        assert!(program.html.contains("a&lt;b") && program.html.contains("class=\"sortable\""));
        assert!(program.library.contains("function sortable("));
    }
}
