//! Small pieces of HTML.

pub use protomer_io::written::html as escape;

/// A paragraph.
pub fn paragraph(text: &str) -> String {
    format!("<p>{}</p>\n", escape(text))
}

/// A list of names and values.
pub fn definitions(rows: &[(&str, String)]) -> String {
    let row = |(name, value): &(&str, String)| {
        format!("<dt>{}</dt><dd>{}</dd>\n", escape(name), escape(value))
    };
    format!("<dl>\n{}</dl>\n", rows.iter().map(row).collect::<String>())
}

/// A cell with more characters than this may be broken into lines.
const LONG_CELL: usize = 28;

/// A table.
pub fn table(columns: &[String], rows: &[Vec<String>]) -> String {
    let cell = |cell: &String, tag: &str| {
        let class = if cell.chars().count() > LONG_CELL {
            " class=\"long\""
        } else {
            ""
        };
        format!("<{tag}{class}>{}</{tag}>", escape(cell))
    };
    let cells =
        |row: &[String], tag: &str| -> String { row.iter().map(|text| cell(text, tag)).collect() };
    let body: String = rows
        .iter()
        .map(|row| format!("<tr>{}</tr>\n", cells(row, "td")))
        .collect();
    format!(
        "<div class=\"scroll\"><table>\n<thead><tr>{}</tr></thead>\n<tbody>\n{body}</tbody>\n</table></div>\n",
        cells(columns, "th")
    )
}

/// A bulleted list.
pub fn list(items: &[String]) -> String {
    format!(
        "<ul>\n{}</ul>\n",
        items
            .iter()
            .map(|item| format!("<li>{}</li>\n", escape(item)))
            .collect::<String>()
    )
}

/// The verbatim text of a file, folded.
pub fn folded_text(title: &str, text: &str) -> String {
    format!(
        "<details><summary>{}</summary><pre>{}</pre></details>\n",
        escape(title),
        escape(text.trim_end())
    )
}

/// A number with `digits` significant digits, without trailing zeros.
pub fn significant(value: f64, digits: usize) -> String {
    if !value.is_finite() || value == 0.0 {
        return if value == 0.0 {
            "0".into()
        } else {
            "–".into()
        };
    }
    let magnitude = value.abs().log10().floor() as i32;
    let text = if (-4..9).contains(&magnitude) {
        let decimals = (digits as i32 - 1 - magnitude).max(0) as usize;
        format!("{value:.decimals$}")
    } else {
        format!("{value:.*e}", digits.saturating_sub(1))
    };
    let (number, exponent) = text
        .split_once('e')
        .map_or((text.as_str(), String::new()), |(n, e)| {
            (n, format!("e{e}"))
        });
    let number = if number.contains('.') {
        number.trim_end_matches('0').trim_end_matches('.')
    } else {
        number
    };
    format!("{number}{exponent}").replace('-', "−")
}

/// A number with `digits` significant digits, or a dash if it is unknown.
pub fn significant_or_dash(value: Option<f64>, digits: usize) -> String {
    match value {
        Some(value) => significant(value, digits),
        None => "–".to_owned(),
    }
}

/// A salt concentration (mol/L) in mmol/L.
pub fn millimolar(salt_molar: f64) -> String {
    significant(1e3 * salt_molar, 6)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_cannot_become_markup() {
        assert_eq!(escape("<a b=\"c\">&"), "&lt;a b=&quot;c&quot;&gt;&amp;");
    }

    #[test]
    fn numbers_are_short() {
        let short = [
            (12.345_678, "12.346"),
            (-0.5, "−0.5"),
            (0.0, "0"),
            (1.0e-7, "1e−7"),
            (123_456.7, "123457"),
        ];
        for (value, text) in short {
            assert_eq!(significant(value, 5), text);
        }
        assert_eq!(significant(f64::NAN, 3), "–");
    }
}
