//! A part of work shared by many machines.

use crate::{Error, Result};

/// Every `of`-th item, starting with item `index` - 1, counted from zero.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shard {
    /// The number of the part, counted from 1.
    pub index: usize,
    /// The number of parts.
    pub of: usize,
}

impl Shard {
    /// All items.
    pub const WHOLE: Shard = Shard { index: 1, of: 1 };

    /// Parses a part written as `2/8`.
    ///
    /// ```
    /// use protomer_results::Shard;
    /// assert_eq!(Shard::parse("2/8").unwrap(), Shard { index: 2, of: 8 });
    /// assert!(Shard::parse("9/8").is_err());
    /// ```
    ///
    /// # Errors
    /// Quotes the input and gives the accepted form.
    pub fn parse(text: &str) -> Result<Self> {
        let parts = text
            .split_once('/')
            .and_then(|(index, count)| Some((index.parse().ok()?, count.parse().ok()?)));
        match parts {
            Some((index, count)) if (1..=count).contains(&index) => Ok(Self { index, of: count }),
            _ => Err(Error::NotAShard(text.to_owned())),
        }
    }

    /// Whether an item belongs to the part.
    ///
    /// ```
    /// use protomer_results::Shard;
    /// let second = Shard { index: 2, of: 3 };
    /// let items: Vec<usize> = (0..9).filter(|number| second.has(*number)).collect();
    /// assert_eq!(items, [1, 4, 7]);
    /// ```
    pub fn has(self, number: usize) -> bool {
        number % self.of == self.index - 1
    }

    /// Whether the part is everything.
    ///
    /// ```
    /// use protomer_results::Shard;
    /// assert!(Shard::WHOLE.is_whole() && !Shard { index: 1, of: 2 }.is_whole());
    /// ```
    pub fn is_whole(self) -> bool {
        self.of == 1
    }
}
