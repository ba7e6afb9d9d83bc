//! Examples of the command line as calls of Python.

use super::{NOT_FOR_FUNCTIONS, identifier};
use clap::{Arg, ArgAction, Command};

/// An example of the command line as a call; `None` if it is of another verb, or has flags that
/// functions lack.
pub fn python_call(command: &Command, path: &[&str], words: &str) -> Option<String> {
    let mut words = words.split_whitespace();
    for word in path {
        if words.next() != Some(word) {
            return None;
        }
    }
    let mut places = Vec::new();
    let mut keywords: Vec<(String, Vec<String>)> = Vec::new();
    while let Some(word) = words.next() {
        let flags = || command.get_arguments().filter(|arg| !arg.is_positional());
        let arg = match (word.strip_prefix("--"), word.strip_prefix('-')) {
            (Some(long), _) => flags().find(|arg| arg.get_long() == Some(long))?,
            (None, Some(short)) => flags().find(|arg| {
                arg.get_short()
                    .is_some_and(|letter| short == letter.to_string())
            })?,
            (None, None) => {
                places.push(format!("\"{word}\""));
                continue;
            }
        };
        if NOT_FOR_FUNCTIONS.contains(&arg.get_id().as_str()) {
            continue;
        }
        let name = identifier(arg.get_long().unwrap_or(arg.get_id().as_str()));
        let value = match arg.get_action() {
            ArgAction::SetTrue => "True".to_owned(),
            _ => {
                let value = words.next()?;
                match value.parse::<f64>() {
                    Ok(_) => value.to_owned(),
                    Err(_) => format!("\"{value}\""),
                }
            }
        };
        match keywords.iter_mut().find(|(keyword, _)| *keyword == name) {
            Some((_, values)) => values.push(value),
            None => keywords.push((name, vec![value])),
        }
    }
    let first = command.get_arguments().find(|arg| arg.is_positional());
    let takes_many = first
        .and_then(Arg::get_num_args)
        .is_some_and(|count| count.max_values() > 1);
    let mut given = match takes_many && places.len() > 1 {
        true => vec![format!("[{}]", places.join(", "))],
        false => places,
    };
    for (name, values) in keywords {
        given.push(match &values[..] {
            [value] => format!("{name}={value}"),
            several => format!("{name}=[{}]", several.join(", ")),
        });
    }
    let mut function = path.iter().map(|word| identifier(word));
    Some(format!(
        "pm.{}({})",
        function.by_ref().collect::<Vec<_>>().join("."),
        given.join(", ")
    ))
}
