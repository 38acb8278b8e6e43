//! Changes between JSON values. Neighbouring states are almost equal, so an exported page stores
//! the changes from state to state.

use serde_json::{Map, Value, json};

/// The maximum number of unchanged elements in a splice. A further splice takes about as much space.
const MAX_UNCHANGED: usize = 2;

/// Returns the change from `old` to `new`, or `None` if they are equal. `patch` in `embedded.js`
/// applies a change:
///
/// - An object with the key `=` replaces the old value by the value of this key.
/// - Any other object changes values in an object. It contains the changes by key.
/// - An array changes elements of an array. It contains splices `[index, count, element...]`, which
///   are applied in order and replace `count` elements by the new elements.
/// - Any other value replaces the old value.
pub(super) fn change(old: &Value, new: &Value) -> Option<Value> {
    match (old, new) {
        _ if old == new => None,
        (Value::Object(old), Value::Object(new)) if old.keys().all(|key| new.contains_key(key)) => {
            let changes = new.iter().filter_map(|(key, value)| {
                let change =
                    old.get(key).map_or_else(|| Some(replacement(value)), |old| change(old, value));
                Some((key.clone(), change?))
            });
            Some(Value::Object(changes.collect::<Map<_, _>>()))
        }
        (Value::Array(old), Value::Array(new)) => Some(splices(old, new)),
        _ => Some(replacement(new)),
    }
}

fn replacement(new: &Value) -> Value {
    if new.is_object() || new.is_array() { json!({ "=": new }) } else { new.clone() }
}

/// Returns the splices that change `old` into `new`.
fn splices(old: &[Value], new: &[Value]) -> Value {
    let one = vec![replaced_middle(old, new)];
    let runs = if old.len() == new.len() { replaced_runs(old, new) } else { Vec::new() };
    let size = |splices: &[Value]| -> usize {
        splices.iter().filter_map(|splice| Some(1 + splice.as_array()?.len())).sum()
    };
    Value::Array(if runs.is_empty() || size(&one) <= size(&runs) { one } else { runs })
}

/// Returns the splice that replaces all elements between the common beginning and the common end.
fn replaced_middle(old: &[Value], new: &[Value]) -> Value {
    let equal = |pairs: &mut dyn Iterator<Item = (&Value, &Value)>| {
        pairs.take_while(|(old, new)| old == new).count()
    };
    let first = equal(&mut old.iter().zip(new));
    let (old, new) = (&old[first..], &new[first..]);
    let last = equal(&mut old.iter().rev().zip(new.iter().rev()));
    splice(first, old.len() - last, &new[..new.len() - last])
}

/// Returns a splice for each run of different elements of two arrays of the same length.
fn replaced_runs(old: &[Value], new: &[Value]) -> Vec<Value> {
    let mut runs: Vec<(usize, usize)> = Vec::new();
    for (index, _) in old.iter().zip(new).enumerate().filter(|(_, (old, new))| old != new) {
        match runs.last_mut() {
            Some((_, end)) if index - *end <= MAX_UNCHANGED => *end = index + 1,
            _ => runs.push((index, index + 1)),
        }
    }
    runs.into_iter().map(|(from, to)| splice(from, to - from, &new[from..to])).collect()
}

fn splice(index: usize, count: usize, elements: &[Value]) -> Value {
    [json!(index), json!(count)].into_iter().chain(elements.iter().cloned()).collect()
}

#[cfg(test)]
mod tests {
    use proptest::collection::{btree_map, vec};
    use proptest::prelude::*;

    use super::*;
    use crate::export::tests::patch;

    #[test]
    fn changes_are_small() {
        let old =
            json!({ "a": [0, 1, 2, 3, 4, 5, 6, 7, 8, 9], "b": { "c": 1, "d": null }, "e": "x" });
        for (path, value, expected) in [
            ("/a/3", json!(0), json!({ "a": [[3, 1, 0]] })),
            ("/b/d", json!([1]), json!({ "b": { "d": { "=": [1] } } })),
            ("/b/c", Value::Null, json!({ "b": { "c": null } })),
            (
                "/a",
                json!([1, 2, 3, 4, 5, 6, 7, 8, 9, 0]),
                json!({ "a": [[0, 10, 1, 2, 3, 4, 5, 6, 7, 8, 9, 0]] }),
            ),
            ("/a", json!([9, 1, 2, 3, 4, 5, 6, 7, 8, 0]), json!({ "a": [[0, 1, 9], [9, 1, 0]] })),
            ("/a", json!([0, 1, 2, 9]), json!({ "a": [[3, 6]] })),
        ] {
            let mut new = old.clone();
            *new.pointer_mut(path).unwrap() = value;
            assert_eq!(change(&old, &new), Some(expected));
        }
        assert_eq!(change(&old, &old), None);
        assert_eq!(change(&json!({ "a": 1 }), &json!({})), Some(json!({ "=": {} })));
    }

    fn values() -> impl Strategy<Value = Value> {
        let leaf = prop_oneof![
            Just(Value::Null),
            (0..3).prop_map(Value::from),
            "[ab]?".prop_map(Value::from)
        ];
        leaf.prop_recursive(3, 40, 8, |inner| {
            prop_oneof![
                vec(inner.clone(), 0..8).prop_map(Value::from),
                btree_map("[a-c]", inner, 0..4).prop_map(|map| map.into_iter().collect()),
            ]
        })
    }

    proptest! {
        #[test]
        fn applying_a_change_yields_the_new_value(old in values(), new in values()) {
            let patched = change(&old, &new).map_or_else(|| old.clone(), |change| patch(&old, &change));
            prop_assert_eq!(patched, new);
        }
    }
}
