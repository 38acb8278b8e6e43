//! A table of a vehicle file that `false` can replace.

use core::fmt;
use core::marker::PhantomData;

use serde::Deserialize;
use serde::de::value::MapAccessDeserializer;
use serde::de::{self, Deserializer, MapAccess, Unexpected, Visitor};

/// A table, or `false` for none.
#[derive(Clone, Copy)]
pub(crate) enum Setting<T> {
    None,
    Table(T),
}

impl<'de, T: Table + Deserialize<'de>> Deserialize<'de> for Setting<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(SettingVisitor(PhantomData))
    }
}

/// A table that a file can replace by `false`.
pub(crate) trait Table {
    /// An example for messages.
    const EXAMPLE: &'static str;
}

struct SettingVisitor<T>(PhantomData<T>);

impl<'de, T: Table + Deserialize<'de>> Visitor<'de> for SettingVisitor<T> {
    type Value = Setting<T>;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "false or a table such as {}", T::EXAMPLE)
    }

    fn visit_bool<E: de::Error>(self, value: bool) -> Result<Self::Value, E> {
        if value {
            return Err(E::invalid_value(Unexpected::Bool(value), &self));
        }
        Ok(Setting::None)
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Self::Value, A::Error> {
        T::deserialize(MapAccessDeserializer::new(map)).map(Setting::Table)
    }
}
