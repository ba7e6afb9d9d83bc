//! The grammar of CIF (Hall, Allen and Brown, Acta Cryst. A47, 655 (1991); CIF 1.1): tokens, loops,
//! rows.
//!
//! One pass that passes each row on as it is read, so that memory is proportional to one row.

use super::messages::{parse_error, quoted};
use crate::{BodyError, Result};

const CUT_SHORT: &str = "the file may be cut short; fetch it again";

/// A value: its text, or nothing for the placeholders `.` and `?`.
pub(crate) type Value<'a> = Option<&'a str>;

/// One row of a category: the item names (without the category, in lower case) and as many values.
pub(crate) struct Row<'a, 'r> {
    pub(crate) category: &'r str,
    pub(crate) items: &'r [String],
    pub(crate) values: &'r [Value<'a>],
    pub(crate) line: usize,
}

impl<'a> Row<'a, '_> {
    /// The value of an item by name.
    pub(crate) fn get(&self, item: &str) -> Value<'a> {
        let index = self.items.iter().position(|name| name == item)?;
        self.values.get(index).copied().flatten()
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Token<'a> {
    /// Token `data_...`.
    Data,
    /// Token `loop_`.
    Loop,
    /// Token `save_...`, `global_` or `stop_`.
    Other,
    /// Token `_category.item`.
    Tag(&'a str),
    Value(Value<'a>),
}

/// Reads the rows of the first data block, calling `on_row` for each row of a category that it
/// `wants`.
pub(crate) fn read_rows<'a>(
    source: &str,
    text: &'a str,
    wants: impl Fn(&str) -> bool,
    on_row: impl FnMut(&Row<'a, '_>) -> Result<()>,
) -> Result<()> {
    let mut parser = Parser {
        tokens: Tokens {
            source,
            text,
            offset: 0,
            line: 1,
        },
        ahead: None,
        wants,
        on_row,
    };
    parser.block()
}

struct Parser<'a, 's, W, F> {
    tokens: Tokens<'a, 's>,
    ahead: Option<(Token<'a>, usize)>,
    wants: W,
    on_row: F,
}

impl<'a, W: Fn(&str) -> bool, F: FnMut(&Row<'a, '_>) -> Result<()>> Parser<'a, '_, W, F> {
    fn next(&mut self) -> Result<Option<(Token<'a>, usize)>> {
        match self.ahead.take() {
            Some(token) => Ok(Some(token)),
            None => self.tokens.next(),
        }
    }

    fn block(&mut self) -> Result<()> {
        let mut blocks = 0;
        while let Some((token, line)) = self.next()? {
            match token {
                Token::Data => {
                    blocks += 1;
                    if blocks > 1 {
                        return Ok(());
                    }
                }
                Token::Loop => self.table(line)?,
                Token::Tag(tag) => self.single_row(tag, line)?,
                Token::Other => {}
                Token::Value(value) => {
                    let value = quoted(value.unwrap_or("?"));
                    let cause = format!("a value {value} that belongs to no item");
                    let remedy = "quote values with blanks; correct the line";
                    return Err(self.error(line, cause, remedy));
                }
            }
        }
        Ok(())
    }

    fn error(&self, line: usize, cause: String, remedy: &str) -> BodyError {
        parse_error(self.tokens.source, line, cause, remedy)
    }

    /// Reads a table: `loop_`, the item names, then values row by row.
    fn table(&mut self, loop_line: usize) -> Result<()> {
        let (category, items) = self.heading()?;
        if self.ahead.is_none() {
            let cause = format!("the loop of {category} has no values");
            let remedy = "the file may be cut short; fetch it again, or remove the loop";
            return Err(self.error(loop_line, cause, remedy));
        }
        let is_wanted = (self.wants)(&category);
        let mut values = Vec::with_capacity(items.len());
        let mut row_line = loop_line;
        while let Some((token, line)) = self.next()? {
            let Token::Value(value) = token else {
                self.ahead = Some((token, line));
                break;
            };
            if items.is_empty() {
                let cause = "a loop without item names".into();
                return Err(self.error(line, cause, "correct the loop_"));
            }
            if values.is_empty() {
                row_line = line;
            }
            values.push(value);
            if values.len() == items.len() {
                if is_wanted {
                    (self.on_row)(&Row {
                        category: &category,
                        items: &items,
                        values: &values,
                        line: row_line,
                    })?;
                }
                values.clear();
            }
        }
        if values.is_empty() {
            return Ok(());
        }
        let (count, expected) = (values.len(), items.len());
        let cause = format!("the last row of {category} has {count} of {expected} values");
        Err(self.error(row_line, cause, CUT_SHORT))
    }

    /// The category and the item names of a loop; the token after them is put back.
    fn heading(&mut self) -> Result<(String, Vec<String>)> {
        let mut items = Vec::new();
        let mut category = String::new();
        while let Some((token, line)) = self.next()? {
            let Token::Tag(tag) = token else {
                self.ahead = Some((token, line));
                break;
            };
            let (of_category, item) = split_tag(tag);
            category = of_category;
            items.push(item);
        }
        Ok((category, items))
    }

    /// Reads pairs `_category.item value` of one category, which make one row.
    fn single_row(&mut self, first_tag: &'a str, first_line: usize) -> Result<()> {
        let (category, first_item) = split_tag(first_tag);
        let mut items = vec![first_item];
        let mut item_line = first_line;
        let mut values = Vec::new();
        while let Some((token, line)) = self.next()? {
            match token {
                Token::Value(value) if values.len() < items.len() => values.push(value),
                Token::Tag(tag) if values.len() == items.len() && in_category(tag, &category) => {
                    items.push(split_tag(tag).1);
                    item_line = line;
                }
                other => {
                    self.ahead = Some((other, line));
                    break;
                }
            }
        }
        if values.len() < items.len() {
            let item = items.last().map_or("", String::as_str);
            let cause = format!("_{category}.{item} has no value");
            return Err(self.error(item_line, cause, CUT_SHORT));
        }
        if (self.wants)(&category) {
            (self.on_row)(&Row {
                category: &category,
                items: &items,
                values: &values,
                line: first_line,
            })?;
        }
        Ok(())
    }
}

/// Category and item of `_category.item`, in lower case as names are compared.
fn split_tag(tag: &str) -> (String, String) {
    let name = tag.trim_start_matches('_').to_ascii_lowercase();
    match name.split_once('.') {
        Some((category, item)) => (category.to_string(), item.to_string()),
        None => (String::new(), name),
    }
}

fn in_category(tag: &str, category: &str) -> bool {
    let name = tag.get(1..).unwrap_or("");
    let length = name.find('.').unwrap_or(0);
    name.get(..length)
        .is_some_and(|prefix| prefix.eq_ignore_ascii_case(category))
}

struct Tokens<'a, 's> {
    source: &'s str,
    text: &'a str,
    offset: usize,
    line: usize,
}

impl<'a> Tokens<'a, '_> {
    fn next(&mut self) -> Result<Option<(Token<'a>, usize)>> {
        self.skip_blanks_and_comments();
        let bytes = self.text.as_bytes();
        let (start, line) = (self.offset, self.line);
        let Some(&first) = bytes.get(start) else {
            return Ok(None);
        };
        let is_line_start = start == 0 || matches!(bytes[start - 1], b'\n' | b'\r');
        let token = match first {
            b';' if is_line_start => Token::Value(Some(self.text_field()?)),
            b'\'' | b'"' => Token::Value(Some(self.quoted_value(first)?)),
            _ => {
                let length = bytes[start..]
                    .iter()
                    .position(u8::is_ascii_whitespace)
                    .unwrap_or(bytes.len() - start);
                self.offset = start + length;
                bare_token(&self.text[start..self.offset])
            }
        };
        Ok(Some((token, line)))
    }

    fn skip_blanks_and_comments(&mut self) {
        let bytes = self.text.as_bytes();
        while let Some(&byte) = bytes.get(self.offset) {
            match byte {
                b'\n' => self.line += 1,
                b'#' => {
                    let length = bytes[self.offset..].iter().position(|b| *b == b'\n');
                    self.offset = length.map_or(bytes.len(), |length| self.offset + length);
                    continue;
                }
                _ if byte.is_ascii_whitespace() => {}
                _ => return,
            }
            self.offset += 1;
        }
    }

    /// A value between quotes; a quote closes it only if a blank follows.
    fn quoted_value(&mut self, quote: u8) -> Result<&'a str> {
        let bytes = self.text.as_bytes();
        let start = self.offset + 1;
        let mut end = start;
        while let Some(&byte) = bytes.get(end) {
            let closes = byte == quote && bytes.get(end + 1).is_none_or(u8::is_ascii_whitespace);
            if closes {
                self.offset = end + 1;
                return Ok(&self.text[start..end]);
            }
            if byte == b'\n' {
                break;
            }
            end += 1;
        }
        let open = quoted(&self.text[self.offset..end]);
        let cause = format!("the quote of {open} is not closed on its line");
        Err(parse_error(
            self.source,
            self.line,
            cause,
            "close the quote",
        ))
    }

    /// Lines between two semicolons at the start of their lines.
    fn text_field(&mut self) -> Result<&'a str> {
        let start = self.offset + 1;
        let Some(length) = self.text[start..].find("\n;") else {
            return Err(parse_error(
                self.source,
                self.line,
                "a text field without its closing semicolon",
                "fetch it again",
            ));
        };
        let field = &self.text[start..start + length];
        self.line += 1 + field.bytes().filter(|byte| *byte == b'\n').count();
        self.offset = start + length + 2;
        Ok(field.trim())
    }
}

fn bare_token(word: &str) -> Token<'_> {
    let begins = |prefix: &str| {
        word.get(..prefix.len())
            .is_some_and(|start| start.eq_ignore_ascii_case(prefix))
    };
    match word {
        "." | "?" => Token::Value(None),
        _ if word.starts_with('_') => Token::Tag(word),
        _ if begins("data_") => Token::Data,
        _ if word.eq_ignore_ascii_case("loop_") => Token::Loop,
        _ if begins("save_") || begins("global_") || begins("stop_") => Token::Other,
        _ => Token::Value(Some(word)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    type OwnedRow = (String, usize, Vec<Option<String>>);

    fn rows(text: &str) -> Result<Vec<OwnedRow>> {
        let mut rows = Vec::new();
        read_rows(
            "test.cif",
            text,
            |_| true,
            |row| {
                rows.push((
                    row.category.to_string(),
                    row.line,
                    row.values.iter().map(|v| v.map(str::to_string)).collect(),
                ));
                Ok(())
            },
        )?;
        Ok(rows)
    }

    #[test]
    fn quotes_text_fields_and_placeholders() {
        let text = "data_x\r\n_a.b 'it's O5'x end'\r\n_a.c \"O5'\"\n_a.d\n;two\nlines\n;\n_a.e ? # note\nloop_\n_l.x\n_l.y\n1 .\n2 z\n#\n";
        let rows = rows(text).unwrap();
        let some = |text: &str| Some(text.to_string());
        assert_eq!(
            rows[0],
            (
                "a".into(),
                2,
                vec![some("it's O5'x end"), some("O5'"), some("two\nlines"), None]
            )
        );
        assert_eq!(rows[1], ("l".into(), 12, vec![some("1"), None]));
        assert_eq!(rows[2], ("l".into(), 13, vec![some("2"), some("z")]));
    }

    #[test]
    fn cut_text_is_an_error_with_its_line() {
        for (text, line, cause) in [
            ("data_x\nloop_\n_l.x\n_l.y\n1 2\n3", 6, "1 of 2"),
            ("data_x\nloop_\n_l.x\n_l.", 2, "no values"),
            ("data_x\nloop_", 2, "no values"),
            ("data_x\n_a.b", 2, "no value"),
            (
                "data_x\n_a.b 1\n_a.c 2\n_a.d\nloop_",
                4,
                "_a.d has no value",
            ),
            ("data_x\n_a.b\n;never", 3, "semicolon"),
            ("data_x\n_a.b 'open\n", 2, "not closed"),
            ("data_x\nstray", 2, "stray"),
        ] {
            let message = rows(text).unwrap_err().to_string();
            assert!(
                message.starts_with(&format!("test.cif:{line}:")) && message.contains(cause),
                "{message}"
            );
        }
    }
}
