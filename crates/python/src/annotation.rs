//! The annotations that wait for the next state.

use std::sync::{Mutex, MutexGuard, PoisonError};

use mmsim_maze::{Cell, Heading, needs_escape};
use mmsim_protocol::{
    Annotation, AnnotationWriter, Colour, MAX_ANNOTATIONS_BYTES, MAX_LOG_BYTES, wall_from_letter,
};
use pyo3::prelude::*;

use crate::convert::letter;
use crate::error::value_error;

/// Encoded annotations in the order in which they were added.
#[derive(Default)]
pub(crate) struct Pending(Mutex<Vec<Vec<u8>>>);

impl Pending {
    fn entries(&self) -> MutexGuard<'_, Vec<Vec<u8>>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(crate) fn clear(&self) {
        self.entries().clear();
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.entries().is_empty()
    }

    /// Adds an annotation. Returns a `ValueError` if it is invalid.
    pub(crate) fn push(&self, annotation: Annotation<'_>) -> PyResult<()> {
        let mut buffer = [0; MAX_ANNOTATIONS_BYTES];
        let mut writer = AnnotationWriter::new(&mut buffer);
        writer.push(annotation).map_err(value_error)?;
        let request = writer.finish().unwrap_or_default();
        self.entries().extend(request.split_first().map(|(_, entry)| entry.to_vec()));
        Ok(())
    }

    /// Returns the next request and the number of its annotations.
    pub(crate) fn request(&self) -> Option<(Vec<u8>, usize)> {
        let (mut request, mut count) = (vec![b'A'], 0);
        for entry in self.entries().iter() {
            if request.len() + entry.len() > MAX_ANNOTATIONS_BYTES {
                break;
            }
            request.extend(entry);
            count += 1;
        }
        (count > 0).then_some((request, count))
    }

    /// Removes annotations that were sent.
    pub(crate) fn remove(&self, count: usize) {
        let mut entries = self.entries();
        let count = count.min(entries.len());
        entries.drain(..count);
    }

    /// Adds a log line for each line of a text. Lines are cut after 1000 bytes.
    pub(crate) fn log(&self, text: &str) -> PyResult<()> {
        let lines = text.lines();
        for line in lines.chain(text.is_empty().then_some("")) {
            let line = printable(line);
            let end = (0..=line.len().min(MAX_LOG_BYTES)).rfind(|&end| line.is_char_boundary(end));
            self.push(Annotation::Log(&line[..end.unwrap_or(0)]))?;
        }
        Ok(())
    }

    /// Declares or withdraws a wall.
    pub(crate) fn wall(&self, cell: Cell, heading: Heading, state: &str) -> PyResult<()> {
        let letter = letter(state).and_then(|letter| u8::try_from(letter).ok());
        let state = letter
            .and_then(wall_from_letter)
            .ok_or_else(|| value_error("a declared wall is 1, 0, ? or -"))?;
        self.push(Annotation::Wall { cell, heading, state })
    }

    /// Sets or clears the colour of a cell.
    pub(crate) fn colour(&self, cell: Cell, letter: Option<&str>) -> PyResult<()> {
        let colour = letter.map(|text| {
            self::letter(text).and_then(Colour::from_letter).ok_or_else(|| {
                let letters = Colour::LETTERS;
                value_error(format_args!("a colour is one of {letters}, found {text:?}"))
            })
        });
        self.push(Annotation::Colour { cell, colour: colour.transpose()? })
    }
}

/// Replaces characters that annotations cannot contain with spaces.
pub(crate) fn printable(text: &str) -> String {
    text.chars().map(|letter| if needs_escape(letter) { ' ' } else { letter }).collect()
}
