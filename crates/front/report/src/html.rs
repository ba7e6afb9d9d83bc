//! Small pieces of HTML.

pub use protomer_common::page::significant;
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

/// A square table of numbers, each shaded by its share of its row.
pub fn shares(corner: &str, names: &[String], rows: &[Vec<f64>]) -> String {
    let head: String = names
        .iter()
        .map(|name| format!("<th>{}</th>", escape(name)))
        .collect();
    let rows = names.iter().zip(rows).map(|(name, row)| {
        let sum: f64 = row.iter().sum();
        let cell = |value: &f64| {
            let share = if sum > 0.0 { value / sum } else { 0.0 };
            let value = significant(*value, 3);
            format!("<td style=\"--share:{share:.3}\">{value}</td>")
        };
        let cells: String = row.iter().map(cell).collect();
        format!("<tr><th>{}</th>{cells}</tr>\n", escape(name))
    });
    format!(
        "<div class=\"scroll\"><table class=\"heat\">\n<thead><tr><th>{}</th>{head}</tr></thead>\n<tbody>\n{}\
         </tbody>\n</table></div>\n",
        escape(corner),
        rows.collect::<String>()
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_cannot_become_markup() {
        assert_eq!(escape("<a b=\"c\">&"), "&lt;a b=&quot;c&quot;&gt;&amp;");
    }
}
