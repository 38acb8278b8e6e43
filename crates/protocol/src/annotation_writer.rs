//! Writes annotations requests without allocating memory.

use mmsim_maze::Excerpt;

use crate::annotations::{Annotation, Entries, MAX_ENTRY_BYTES, colour_letter, wall_letter};
use crate::error::RequestError;
use crate::layout::{BufferTooSmall, MAX_ANNOTATIONS_BYTES};
use crate::message::heading_byte;

/// Writes annotations requests into the caller's buffer.
pub struct AnnotationWriter<'b> {
    buffer: &'b mut [u8],
    length: usize,
}

/// The reason why an annotation was not written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum AnnotationError {
    /// The annotation does not fit into the rest of the buffer or request. Earlier
    /// annotations are kept: send them, and write this one into a new request.
    #[error(transparent)]
    BufferTooSmall(#[from] BufferTooSmall),
    /// A text is too long or contains characters that are not printable.
    #[error(transparent)]
    Invalid(#[from] RequestError),
}

impl<'b> AnnotationWriter<'b> {
    /// Creates a writer for one request. It uses at most [`MAX_ANNOTATIONS_BYTES`] bytes of the
    /// buffer.
    pub fn new(buffer: &'b mut [u8]) -> Self {
        let length = buffer.len().min(MAX_ANNOTATIONS_BYTES);
        Self { buffer: &mut buffer[..length], length: 0 }
    }

    /// Adds an annotation. An annotation with an error changes nothing.
    ///
    /// # Errors
    /// Returns an error if the annotation does not fit, or if its text is invalid.
    pub fn push(&mut self, annotation: Annotation<'_>) -> Result<(), AnnotationError> {
        let start = self.length.max(1);
        let mut end = start;
        // Lengths that do not fit into their field are found to be invalid below.
        let length = |text: &str| u8::try_from(text.len()).unwrap_or(u8::MAX);
        match annotation {
            Annotation::Text { cell, text } => {
                self.put(&mut end, &[b'T', cell.x, cell.y, length(text)]);
                self.put(&mut end, text.as_bytes());
            }
            Annotation::Colour { cell, colour } => {
                self.put(&mut end, &[b'C', cell.x, cell.y, colour_letter(colour)]);
            }
            Annotation::Wall { cell, heading, state } => {
                let side = heading_byte(heading);
                self.put(&mut end, &[b'D', cell.x, cell.y, side, wall_letter(state)]);
            }
            Annotation::Log(line) => {
                let [low, high] = u16::try_from(line.len()).unwrap_or(u16::MAX).to_le_bytes();
                self.put(&mut end, &[b'L', low, high]);
                self.put(&mut end, line.as_bytes());
            }
            Annotation::Mouse(name) | Annotation::Strategy(name) => {
                let kind = if matches!(annotation, Annotation::Mouse(_)) { b'M' } else { b'S' };
                self.put(&mut end, &[kind, length(name)]);
                self.put(&mut end, name.as_bytes());
            }
            Annotation::Restart => self.put(&mut end, b"R"),
            Annotation::ClearTexts => self.put(&mut end, b"t"),
            Annotation::ClearColours => self.put(&mut end, b"c"),
            Annotation::ClearWalls => self.put(&mut end, b"d"),
        }
        if end - start > MAX_ENTRY_BYTES {
            let found = Excerpt::new(self.buffer.get(start..).unwrap_or_default());
            let expected = "an annotation of at most 1003 bytes";
            return Err(RequestError::Annotation { offset: start, expected, found }.into());
        }
        let found = self.buffer.len();
        let message = self.buffer.get(..end).ok_or(BufferTooSmall { expected: end, found })?;
        Entries { message, offset: start }.take()?;
        self.length = end;
        Ok(())
    }

    /// Returns the request, or `None` if it has no annotations.
    pub fn finish(self) -> Option<&'b [u8]> {
        let Self { buffer, length } = self;
        *buffer.first_mut()? = b'A';
        buffer.get(..length).filter(|message| !message.is_empty())
    }

    /// Writes bytes if they fit, and always advances `end` past them.
    fn put(&mut self, end: &mut usize, bytes: &[u8]) {
        let start = *end;
        *end += bytes.len();
        if let Some(space) = self.buffer.get_mut(start..*end) {
            space.copy_from_slice(bytes);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::borrow::ToOwned;

    use mmsim_maze::Cell;

    use super::*;
    use crate::annotations::{MAX_LOG_BYTES, MAX_NAME_BYTES, MAX_TEXT_CHARS};

    #[test]
    fn longest_texts_are_accepted() {
        let name = "n".repeat(MAX_NAME_BYTES);
        let line = "l".repeat(MAX_LOG_BYTES);
        let text = "\u{10ffff}".repeat(MAX_TEXT_CHARS);
        let cell = Cell::new(0, 0);
        for (longest, suffix) in [
            (Annotation::Text { cell, text: &text }, "t"),
            (Annotation::Log(&line), "l"),
            (Annotation::Mouse(&name), "n"),
            (Annotation::Strategy(&name), "n"),
        ] {
            let mut buffer = [0; MAX_ANNOTATIONS_BYTES];
            AnnotationWriter::new(&mut buffer).push(longest).unwrap();
            let longer = |text: &str| text.to_owned() + suffix;
            let (text, line, name) = (longer(&text), longer(&line), longer(&name));
            let too_long = match longest {
                Annotation::Text { .. } => Annotation::Text { cell, text: &text },
                Annotation::Log(_) => Annotation::Log(&line),
                Annotation::Mouse(_) => Annotation::Mouse(&name),
                _ => Annotation::Strategy(&name),
            };
            let result = AnnotationWriter::new(&mut buffer).push(too_long);
            assert!(matches!(result, Err(AnnotationError::Invalid(_))), "{result:?}");
        }
        for length in [256, 65_536, 1 << 20] {
            let text = "x".repeat(length);
            let mut buffer = [0; 64];
            let result = AnnotationWriter::new(&mut buffer).push(Annotation::Mouse(&text));
            assert!(result.is_err());
        }
    }

    #[test]
    fn a_full_buffer_keeps_earlier_annotations() {
        let mut buffer = [0; 6];
        assert_eq!(AnnotationWriter::new(&mut buffer).finish(), None);
        assert_eq!(AnnotationWriter::new(&mut []).finish(), None);
        let mut writer = AnnotationWriter::new(&mut buffer);
        let colour = Annotation::Colour { cell: Cell::new(1, 2), colour: None };
        writer.push(colour).unwrap();
        let too_small = BufferTooSmall { expected: 9, found: 6 };
        assert_eq!(writer.push(colour), Err(too_small.into()));
        assert!(writer.push(Annotation::Log("\n")).is_err());
        writer.push(Annotation::ClearTexts).unwrap();
        assert_eq!(writer.finish(), Some(&b"AC\x01\x02-t"[..]));
        let mut large = [0; 2 * MAX_ANNOTATIONS_BYTES];
        let buffer_bytes = large.len();
        let mut writer = AnnotationWriter::new(&mut large);
        let written =
            (0..buffer_bytes).take_while(|_| writer.push(Annotation::ClearTexts).is_ok()).count();
        assert_eq!(written, MAX_ANNOTATIONS_BYTES - 1);
        assert_eq!(writer.finish().unwrap().len(), MAX_ANNOTATIONS_BYTES);
    }
}
