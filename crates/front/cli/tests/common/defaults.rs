//! Defaults that pages of the documentation repeat.
//!
//! Tables of options in the guide have cells such as `--contact-gap 5`, with the default or with another example. The
//! help knows the default only, so a cell is corrected when it had the default of the reference page and that changes.

use std::collections::BTreeMap;

/// The default of each flag of each verb, as a reference page has them.
pub type Defaults = BTreeMap<(String, String), String>;

/// Reads the defaults in a reference page; those in words, of several parts, are left out.
pub fn read(reference: &str) -> Defaults {
    let mut defaults = Defaults::new();
    let (mut verb, mut flag) = (String::new(), String::new());
    // The help breaks its lines anywhere.
    let reference = reference.replace("[default:\n", "[default: ");
    for line in reference.lines() {
        if let Some(title) = line.strip_prefix("## protomer") {
            verb = title.trim().to_owned();
        }
        let words: Vec<&str> = line.split_whitespace().collect();
        if let Some(long) = words.iter().take(2).find(|word| word.starts_with("--"))
            && line.starts_with("  ")
        {
            flag = (*long).to_owned();
        }
        if let Some((_, rest)) = line.split_once("[default: ")
            && let Some((default, _)) = rest.trim_start().split_once(']')
            && !default.contains([' ', ','])
        {
            defaults.insert((verb.clone(), flag.clone()), default.to_owned());
        }
    }
    defaults
}

/// The guide page of a verb, or of a group of verbs, with the new defaults in the place of the old ones.
pub fn carried_over(page: &str, name: &str, old: &Defaults, new: &Defaults) -> String {
    let mut lines: Vec<String> = page.lines().map(str::to_owned).collect();
    for ((verb, flag), default) in new {
        let Some(before) = old.get(&(verb.clone(), flag.clone())) else {
            continue;
        };
        let is_of_page = verb.split(' ').next() == Some(name) || verb.replace(' ', "-") == name;
        if before == default || !is_of_page {
            continue;
        }
        let [stale, fresh] = [before, default].map(|value| format!("`{flag} {value}`"));
        for line in lines.iter_mut().filter(|line| line.starts_with("| ")) {
            *line = line.replace(&stale, &fresh);
        }
    }
    lines.join("\n") + "\n"
}

/// A page with the defaults of these settings in the lines `key = number` of its blocks of TOML.
pub fn with_settings(page: &str, settings: &toml::Table) -> String {
    let mut is_toml = false;
    let mut text = String::new();
    for line in page.lines() {
        if line.starts_with("```") {
            is_toml = line == "```toml";
        }
        text += &match line.split_once(" = ").filter(|_| is_toml) {
            Some((key, rest)) => settings
                .get(key)
                .map_or_else(|| line.to_owned(), |value| with_value(key, value, rest)),
            None => line.to_owned(),
        };
        text.push('\n');
    }
    text
}

/// The line of a setting; what follows the value stays, in its column if it fits.
fn with_value(key: &str, value: &toml::Value, rest: &str) -> String {
    let (present, comment) = match rest.find('#') {
        Some(start) => rest.split_at(start),
        None => (rest, ""),
    };
    let width = if comment.is_empty() { 0 } else { present.len() };
    format!("{key} = {:width$}{comment}", value.to_string())
}

#[test]
fn a_default_that_changes_is_carried_over() {
    let reference = |gap: &str| {
        format!(
            "## protomer pair\n\n      --contact-gap <GAP>\n          Surfaces, Å\n\n          [default: {gap}]\n\
             \n      --ph <PH>\n          pH [default: 7.4, or none]\n      \
             --tolerance <KT>\n          Error [default:\n          0.001]\n"
        )
    };
    let [old, new] = ["5", "4"].map(|gap| read(&reference(gap)));
    assert_eq!(old.len(), 2);
    let page = "`--contact-gap 5`\n| `--contact-gap 5` | Å |\n| `--contact-gap 6` | Å |\n";
    let carried = carried_over(page, "pair", &old, &new);
    assert_eq!(
        carried,
        "`--contact-gap 5`\n| `--contact-gap 4` | Å |\n| `--contact-gap 6` | Å |\n"
    );
    assert_eq!(carried_over(page, "simulate", &old, &new), page);
}

#[test]
fn a_block_of_settings_has_their_defaults() {
    let settings: toml::Table = toml::from_str("sweeps = 100\ngap = 4.0").unwrap();
    let page = "gap = 5.0\n```toml\nsweeps = 2000   # long\ngap = 5.0\nother = 1\n```\n";
    assert_eq!(
        with_settings(page, &settings),
        "gap = 5.0\n```toml\nsweeps = 100    # long\ngap = 4.0\nother = 1\n```\n"
    );
}
