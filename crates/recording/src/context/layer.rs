//! A text or another value for each cell.

use std::fmt;

use mmsim_protocol::MAX_TEXT_BYTES;

/// A value for each cell or wall. The list is empty if all values are the default.
#[derive(Clone, Debug)]
pub(crate) struct Layer<T>(pub(crate) Vec<T>);

impl<T: Copy + Default + PartialEq> Layer<T> {
    pub(crate) fn get(&self, index: usize) -> T {
        self.0.get(index).copied().unwrap_or_default()
    }

    /// Changes one of `length` values.
    pub(crate) fn set(&mut self, index: usize, value: T, length: usize) {
        if self.0.is_empty() && value != T::default() {
            self.0.resize(length, T::default());
        }
        if let Some(old) = self.0.get_mut(index) {
            *old = value;
        }
    }

    /// Returns each value of `next` that differs from the old value, with its index. If `next` has no
    /// values, the old values must have been cleared.
    pub(crate) fn changes<'l>(&'l self, next: &'l Self) -> impl Iterator<Item = (usize, &'l T)> {
        let has_changed = |&(index, &value): &(usize, &T)| value != self.get(index);
        next.0.iter().enumerate().filter(has_changed)
    }

    /// Returns true if there are fewer changes to `next` if all values are cleared first.
    pub(crate) fn is_cheaper_to_clear(&self, next: &Self) -> bool {
        let is_set = |value: &&T| **value != T::default();
        if next.0.is_empty() {
            self.0.iter().any(|value| is_set(&value))
        } else {
            self.changes(next).count() > 1 + next.0.iter().filter(is_set).count()
        }
    }
}

impl<T> Default for Layer<T> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<T: Copy + Default + PartialEq> PartialEq for Layer<T> {
    fn eq(&self, other: &Self) -> bool {
        let length = self.0.len().max(other.0.len());
        (0..length).all(|index| self.get(index) == other.get(index))
    }
}

impl<T: Copy + Default + Eq> Eq for Layer<T> {}

/// The text of a cell.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) struct Text {
    pub(crate) length: u8,
    /// The text, followed by zeros.
    bytes: [u8; MAX_TEXT_BYTES],
}

impl Text {
    /// Returns `None` if the text is too long.
    pub(crate) fn new(text: &str) -> Option<Self> {
        let mut bytes = [0; MAX_TEXT_BYTES];
        bytes.get_mut(..text.len())?.copy_from_slice(text.as_bytes());
        Some(Self { length: text.len().try_into().ok()?, bytes })
    }

    /// Returns the number that the text displays, or `None` if the text is not the decimal
    /// representation of a number.
    pub(crate) fn number(&self) -> Option<u32> {
        let digits = self.as_str();
        let is_decimal = digits.bytes().all(|byte| byte.is_ascii_digit());
        let has_leading_zero = digits.len() > 1 && digits.starts_with('0');
        if is_decimal && !has_leading_zero { digits.parse().ok() } else { None }
    }

    pub(crate) fn as_str(&self) -> &str {
        let bytes = self.bytes.get(..self.length.into()).unwrap_or_default();
        str::from_utf8(bytes).unwrap_or_default()
    }
}

impl Default for Text {
    fn default() -> Self {
        Self { length: 0, bytes: [0; MAX_TEXT_BYTES] }
    }
}

impl fmt::Debug for Text {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.as_str().fmt(f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_decimal_numbers_are_numbers() {
        let number = |text: &str| Text::new(text).unwrap().number();
        for n in [0, 7, 10, 2000, u32::MAX] {
            assert_eq!(number(&n.to_string()), Some(n));
        }
        for text in ["", "00", "07", "+7", "-7", "7 ", "4294967296", "\u{221e}", "a"] {
            assert_eq!(number(text), None, "{text:?}");
        }
        assert_eq!(Text::new(&"x".repeat(MAX_TEXT_BYTES)).unwrap().as_str().len(), MAX_TEXT_BYTES);
        assert_eq!(Text::new(&"x".repeat(MAX_TEXT_BYTES + 1)), None);
    }

    #[test]
    fn layers_are_equal_if_their_values_are() {
        let (mut layer, empty) = (Layer::default(), Layer::default());
        layer.set(3, 0, 5);
        assert!(layer.0.is_empty());
        layer.set(3, 7, 5);
        assert_ne!(layer, empty);
        assert_eq!((layer.get(3), layer.get(4), layer.get(9)), (7, 0, 0));
        assert!(layer.is_cheaper_to_clear(&empty) && !empty.is_cheaper_to_clear(&layer));
        assert!(empty.changes(&layer).eq([(3, &7)]));
        layer.set(3, 0, 5);
        assert!(layer == empty && !layer.is_cheaper_to_clear(&empty));
    }
}
