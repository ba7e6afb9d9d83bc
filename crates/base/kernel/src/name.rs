//! Names that users and files choose: what they may hold.
//!
//! Names go into tables, scripts for viewers, pages and messages. A character that ends a line, moves the
//! cursor or turns the direction of writing makes text there look like, or become, something else. Readers
//! refuse such names; writers replace what has come in all the same.

use std::borrow::Cow;

/// Replacement for a character that a name may not hold.
pub const REPLACEMENT: char = '\u{FFFD}';

/// Whether a character cannot be part of a name: a control character, an end of a line or a paragraph,
/// a mark of the direction of writing.
///
/// ```
/// use protomer_kernel::name::is_forbidden;
/// assert!(is_forbidden('\n') && is_forbidden('\u{1b}') && is_forbidden('\u{202e}'));
/// assert!(!is_forbidden('β') && !is_forbidden(' ') && !is_forbidden('<'));
/// ```
pub fn is_forbidden(character: char) -> bool {
    character.is_control()
        || matches!(
            character,
            '\u{061C}'
                | '\u{200E}'
                | '\u{200F}'
                | '\u{2028}'..='\u{202E}'
                | '\u{2066}'..='\u{2069}'
                | '\u{FEFF}'
        )
}

/// The first character that a name may not hold.
///
/// ```
/// use protomer_kernel::name::first_forbidden;
/// assert_eq!(first_forbidden("lysozyme 2"), None);
/// assert_eq!(first_forbidden("a\nb"), Some('\n'));
/// ```
pub fn first_forbidden(name: &str) -> Option<char> {
    name.chars().find(|character| is_forbidden(*character))
}

/// The text on one line, with every forbidden character replaced.
///
/// ```
/// use protomer_kernel::name::printable;
/// assert_eq!(printable("lysozyme"), "lysozyme");
/// assert_eq!(printable("a\r\nopen x"), "a\u{FFFD}\u{FFFD}open x");
/// ```
pub fn printable(text: &str) -> Cow<'_, str> {
    match first_forbidden(text) {
        None => Cow::Borrowed(text),
        Some(_) => Cow::Owned(replaced(text, is_forbidden, REPLACEMENT)),
    }
}

/// The text with every character of a kind replaced by another.
///
/// ```
/// use protomer_kernel::name::replaced;
/// assert_eq!(replaced("chain A/B", |character| character == '/', '-'), "chain A-B");
/// ```
pub fn replaced(text: &str, is_bad: impl Fn(char) -> bool, substitute: char) -> String {
    let characters = text.chars();
    characters
        .map(|character| {
            if is_bad(character) {
                substitute
            } else {
                character
            }
        })
        .collect()
}
