//! Lists of annotations that are longer than one request.

use mmsim_maze::MazeSize;
use mmsim_protocol::{Annotation, Annotations};

/// The annotations of several requests (`A`). Each request follows its length.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct AnnotationList<'a>(&'a [u8]);

impl<'a> AnnotationList<'a> {
    /// Returns true if there are no annotations.
    pub const fn is_empty(self) -> bool {
        self.0.is_empty()
    }

    /// Returns the length of the list in bytes.
    pub(crate) const fn len(self) -> usize {
        self.0.len()
    }

    /// Iterates over the annotations.
    pub fn iter(self) -> impl Iterator<Item = Annotation<'a>> {
        // The size does not matter, because the cells have been checked.
        let annotations = |request| Annotations::decode(request, MazeSize::HALF_SIZE);
        Requests(self.0).filter_map(move |it| annotations(it).ok()).flat_map(|it| it.iter())
    }

    /// Creates a list from bytes to which requests were added with [`put_request`].
    pub(crate) const fn from_requests(bytes: &'a [u8]) -> Self {
        Self(bytes)
    }
}

/// The remaining requests of a list.
struct Requests<'a>(&'a [u8]);

impl<'a> Iterator for Requests<'a> {
    type Item = &'a [u8];

    fn next(&mut self) -> Option<&'a [u8]> {
        let (length, rest) = self.0.split_first_chunk()?;
        let (request, rest) = rest.split_at_checked(u16::from_le_bytes(*length).into())?;
        self.0 = rest;
        Some(request)
    }
}

/// Appends a request to a list.
pub(crate) fn put_request(list: &mut Vec<u8>, annotations: Annotations<'_>) {
    let request = annotations.as_bytes();
    // The length fits, because a request has at most `MAX_ANNOTATIONS_BYTES`.
    let length = u16::try_from(request.len()).unwrap_or(u16::MAX);
    list.extend(length.to_le_bytes());
    list.extend_from_slice(request);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_contain_the_annotations_of_all_requests() {
        let size = MazeSize::HALF_SIZE;
        let requests = [&b"AcdL\x01\0x"[..], b"AT\x1f\x1f\x011", b"At"];
        let requests = requests.map(|request| Annotations::decode(request, size).unwrap());
        let mut list = Vec::new();
        for request in requests {
            put_request(&mut list, request);
        }
        let list = AnnotationList::from_requests(&list);
        assert!(list.iter().eq(requests.iter().flat_map(Annotations::iter)));
        assert_eq!(list.iter().count(), 5);
        assert!(AnnotationList::default().is_empty() && !list.is_empty());
    }
}
