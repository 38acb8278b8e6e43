//! Vehicles as TOML text.

mod error;
mod load;

use alloc::borrow::Cow;
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;
use core::fmt::{self, Write as _};
use core::marker::PhantomData;
use std::collections::HashMap;

use mmsim_maze::needs_escape;
use serde::Deserialize;
use serde::de::value::MapAccessDeserializer;
use serde::de::{Deserializer, Error, MapAccess, Unexpected, Visitor};

pub use error::{VehicleFileError, VehicleFileFault};
use error::{in_terms_of_toml, line_number};
pub use load::LoadVehicleError;

use crate::straight::StraightLimits;
use crate::turn::TurnKind;
use crate::vehicle::{Arc, Vehicle, VehicleError, VehicleParameters, length_of_180};
use crate::warning::STANDARD_GRAVITY;

/// The size of a cell of a classic maze, in mm.
const CLASSIC_CELL: f64 = 180.0;

/// The maximum length of a name in a text, in characters.
const MAX_NAME: usize = 64;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct VehicleFile {
    name: Option<String>,
    base: Option<String>,
    cell: Option<f64>,
    start_offset: Option<f64>,
    stop_offset: Option<f64>,
    search_speed: Option<f64>,
    search_turn_time: Option<f64>,
    along: Option<LimitsTable>,
    diagonal: Option<Setting<LimitsTable>>,
    #[serde(default)]
    turns: HashMap<TurnKind, Setting<ArcTable>>,
}

#[derive(Default, Deserialize)]
#[serde(
    deny_unknown_fields,
    expecting = "a table such as { acceleration = 9000, top_speed = 3000 }"
)]
struct LimitsTable {
    acceleration: Option<f64>,
    braking: Option<f64>,
    top_speed: Option<f64>,
    jerk: Option<f64>,
}

#[derive(Clone, Copy, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct ArcTable {
    length: Option<f64>,
    speed: Option<f64>,
}

impl Table for LimitsTable {
    const EXAMPLE: &'static str = "{ acceleration = 9000, top_speed = 3000 }";
}

impl Table for ArcTable {
    const EXAMPLE: &'static str = "{ length = 116, speed = 500 }";
}

impl<'de> Deserialize<'de> for TurnKind {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let name = Cow::<str>::deserialize(deserializer)?;
        Self::from_name(&name).ok_or_else(|| {
            let names = Self::ALL.map(Self::name).join(", ");
            D::Error::custom(format!("unknown turn `{name}`, expected one of {names}"))
        })
    }
}

impl Vehicle {
    /// Reads a vehicle from TOML text. If the text contains no name, the vehicle has the given one.
    ///
    /// All lengths are in mm, times in s, speeds in mm/s, accelerations in mm/s² and jerks in mm/s³.
    /// The defaults of optional keys are:
    ///
    /// | key | default |
    /// |---|---|
    /// | `name` | the argument `name` |
    /// | `base` | none; all other values default to those of the preset with this name |
    /// | `cell` | 180, the size of a cell |
    /// | `start_offset`, `stop_offset` | a quarter of `cell` |
    /// | `along.braking`, `diagonal.braking` | the acceleration |
    /// | `along.jerk`, `diagonal.jerk` | `inf`, no limit |
    /// | `diagonal` | none; the mouse does not drive diagonally |
    /// | `turns.180.length` | the only possible length |
    ///
    /// `diagonal = false` removes the limits on diagonals and the turns onto, on and off diagonals
    /// of the base. `turns.l90 = false` removes a turn of the base.
    ///
    /// # Errors
    /// Returns an error with its line if the text is not TOML, if a key is unknown or missing, or
    /// if the mouse is impossible (see [`Vehicle::new`]).
    ///
    /// ```
    /// use mmsim_fastrun::{TurnKind, Vehicle};
    /// let text = "
    ///     search_speed = 500
    ///     search_turn_time = 0.25
    ///
    ///     [along]
    ///     acceleration = 6000
    ///     top_speed = 3000
    ///
    ///     [turns]
    ///     s90 = { length = 116, speed = 600 }
    /// ";
    /// let vehicle = Vehicle::from_toml(text, "mine")?;
    /// assert_eq!(vehicle.name(), "mine");
    /// assert_eq!(vehicle.parameters().along.braking, 6000.0);
    ///
    /// let faster = Vehicle::from_toml("base = 'expert'\nturns.l90.speed = 1700", "faster")?;
    /// assert_eq!(faster.arc(TurnKind::L90).unwrap().arc.speed, 1700.0);
    /// # Ok::<(), mmsim_fastrun::VehicleFileError>(())
    /// ```
    pub fn from_toml(text: &str, name: &str) -> Result<Self, VehicleFileError> {
        let file: VehicleFile = toml::from_str(text).map_err(|error| VehicleFileError {
            line: error.span().map(|span| line_number(text, span.start)),
            fault: VehicleFileFault::Toml(in_terms_of_toml(error.message())),
        })?;
        let base = file.base.clone();
        file.vehicle(name).map_err(|fault| fault.in_text(text, base))
    }

    /// Writes the vehicle as TOML text, which [`from_toml`](Self::from_toml) reads.
    ///
    /// ```
    /// use mmsim_fastrun::Vehicle;
    /// let ares = Vehicle::ares();
    /// assert_eq!(Vehicle::from_toml(&ares.to_toml(), ""), Ok(ares));
    /// ```
    pub fn to_toml(&self) -> String {
        let VehicleParameters {
            name,
            half_cell,
            along,
            diagonal,
            start_offset,
            stop_offset,
            search_speed,
            search_turn_time,
            ..
        } = self.parameters();
        let mut text = format!(
            "# Lengths in mm, times in s, speeds in mm/s, accelerations in mm/s².\n\
             name = {}\ncell = {}\nstart_offset = {start_offset}\nstop_offset = {stop_offset}\n\
             search_speed = {search_speed}\nsearch_turn_time = {search_turn_time}\n",
            quoted(name),
            2.0 * half_cell
        );
        // Writing to a string cannot fail.
        for (table, limits) in [("along", Some(along)), ("diagonal", diagonal.as_ref())] {
            let Some(StraightLimits { acceleration, braking, top_speed, jerk }) = limits else {
                continue;
            };
            let _ = write!(
                text,
                "\n[{table}]\nacceleration = {acceleration}\nbraking = {braking}\n\
                 top_speed = {top_speed}\n"
            );
            if *jerk < f64::INFINITY {
                let _ = writeln!(text, "jerk = {jerk}");
            }
        }
        text.push_str("\n[turns] # with their centripetal accelerations\n");
        for kind in TurnKind::ALL {
            let Some(Arc { length, speed }) = self.arc(kind).map(|fitted| fitted.arc) else {
                continue;
            };
            let acceleration = self.centripetal_acceleration(kind).unwrap_or_default();
            let table = match kind {
                TurnKind::L180 => format!("{{ speed = {speed} }}"),
                _ => format!("{{ length = {length}, speed = {speed} }}"),
            };
            let g = acceleration / STANDARD_GRAVITY;
            let _ = writeln!(text, "{:<46} # {g:.2} g", format!("{kind} = {table}"));
        }
        text
    }
}

impl VehicleFile {
    /// Completes the parameters with those of the base and the defaults, and checks them.
    fn vehicle(self, name: &str) -> Result<Vehicle, VehicleFileFault> {
        let length = self.name.as_ref().map(|name| name.trim().chars().count());
        if let Some(found) = length.filter(|length| !(1..=MAX_NAME).contains(length)) {
            return Err(VehicleFileFault::Name { found });
        }
        let base = self.base.map(|found| match Vehicle::preset(&found) {
            Some(vehicle) => Ok(vehicle.parameters().clone()),
            None => Err(VehicleFileFault::UnknownBase { found }),
        });
        let base = base.transpose()?;
        let has_diagonal = !matches!(self.diagonal, Some(Setting::None));
        let base = base.as_ref();
        let cell = self.cell.or(base.map(|base| 2.0 * base.half_cell)).unwrap_or(CLASSIC_CELL);
        let half_cell = cell / 2.0;
        let of_base = |offset: fn(&VehicleParameters) -> f64| {
            base.filter(|_| self.cell.is_none()).map_or(half_cell / 2.0, offset)
        };
        let along = self.along.unwrap_or_default().limits("along", base.map(|base| base.along))?;
        let on_diagonal = base.and_then(|base| base.diagonal);
        let diagonal = match self.diagonal {
            Some(Setting::Table(table)) => Some(table.limits("diagonal", on_diagonal)?),
            Some(Setting::None) => None,
            None => on_diagonal,
        };
        let mut turns = Vec::new();
        for kind in TurnKind::ALL {
            let is_driven = has_diagonal || !kind.begins_diagonal() && !kind.ends_diagonal();
            let arc = base.filter(|_| is_driven).and_then(|base| {
                base.turns.iter().find(|(other, _)| *other == kind).map(|(_, arc)| *arc)
            });
            let table = match self.turns.get(&kind) {
                Some(Setting::Table(table)) => *table,
                None if arc.is_some() => ArcTable::default(),
                Some(Setting::None) | None => continue,
            };
            turns.push((kind, table.arc(kind, arc, half_cell)?));
        }
        let of_search = |own: Option<f64>, key: &str, of_base: fn(&VehicleParameters) -> f64| {
            own.or(base.map(of_base))
                .ok_or_else(|| VehicleFileFault::Missing { key: key.into(), base: None })
        };
        let parameters = VehicleParameters {
            name: self.name.unwrap_or_else(|| name.into()).into(),
            half_cell,
            along,
            diagonal,
            turns,
            start_offset: self.start_offset.unwrap_or_else(|| of_base(|base| base.start_offset)),
            stop_offset: self.stop_offset.unwrap_or_else(|| of_base(|base| base.stop_offset)),
            search_speed: of_search(self.search_speed, "search_speed", |base| base.search_speed)?,
            search_turn_time: of_search(self.search_turn_time, "search_turn_time", |base| {
                base.search_turn_time
            })?,
        };
        Vehicle::new(parameters).map_err(|error| VehicleFileFault::Vehicle(as_cell(error)))
    }
}

impl LimitsTable {
    fn limits(
        self,
        table: &str,
        base: Option<StraightLimits>,
    ) -> Result<StraightLimits, VehicleFileFault> {
        let value = |own: Option<f64>, base: Option<f64>, key: &str| {
            own.or(base).ok_or_else(|| VehicleFileFault::Missing {
                key: format!("{table}.{key}"),
                base: None,
            })
        };
        let acceleration =
            value(self.acceleration, base.map(|base| base.acceleration), "acceleration")?;
        let braking = base.filter(|_| self.acceleration.is_none()).map(|base| base.braking);
        Ok(StraightLimits {
            acceleration,
            braking: self.braking.or(braking).unwrap_or(acceleration),
            top_speed: value(self.top_speed, base.map(|base| base.top_speed), "top_speed")?,
            jerk: self.jerk.or(base.map(|base| base.jerk)).unwrap_or(f64::INFINITY),
        })
    }
}

impl ArcTable {
    fn arc(self, kind: TurnKind, base: Option<Arc>, half: f64) -> Result<Arc, VehicleFileFault> {
        let missing =
            |key| VehicleFileFault::Missing { key: format!("turns.{kind}.{key}"), base: None };
        // The length of the turn by 180° depends on the cell only.
        let length = match kind {
            TurnKind::L180 => Some(length_of_180(half)),
            _ => base.map(|base| base.length),
        };
        let length = self.length.or(length).ok_or_else(|| missing("length"))?;
        let speed = self.speed.or(base.map(|base| base.speed)).ok_or_else(|| missing("speed"))?;
        Ok(Arc { length, speed })
    }
}

/// A table, or `false` for none.
#[derive(Clone, Copy)]
enum Setting<T> {
    None,
    Table(T),
}

impl<'de, T: Table + Deserialize<'de>> Deserialize<'de> for Setting<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(SettingVisitor(PhantomData))
    }
}

/// A table that a file can replace by `false`.
trait Table {
    /// An example for messages.
    const EXAMPLE: &'static str;
}

struct SettingVisitor<T>(PhantomData<T>);

impl<'de, T: Table + Deserialize<'de>> Visitor<'de> for SettingVisitor<T> {
    type Value = Setting<T>;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "false or a table such as {}", T::EXAMPLE)
    }

    fn visit_bool<E: Error>(self, value: bool) -> Result<Self::Value, E> {
        if value {
            return Err(E::invalid_value(Unexpected::Bool(value), &self));
        }
        Ok(Setting::None)
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Self::Value, A::Error> {
        T::deserialize(MapAccessDeserializer::new(map)).map(Setting::Table)
    }
}

/// Replaces half a cell in an error by the cell, which is in the text.
fn as_cell(error: VehicleError) -> VehicleError {
    match error {
        VehicleError::OutOfRange { key, found, unit, range } if key == "half_cell" => {
            let range = 2.0 * range.start()..=2.0 * range.end();
            VehicleError::OutOfRange { key: "cell".into(), found: 2.0 * found, unit, range }
        }
        error => error,
    }
}

/// Returns a text as a TOML string.
fn quoted(text: &str) -> String {
    let mut quoted = String::from('"');
    for character in text.chars() {
        match character {
            '"' | '\\' => quoted.extend(['\\', character]),
            character if needs_escape(character) => {
                // Writing to a string cannot fail.
                let _ = write!(quoted, "\\u{:04X}", u32::from(character));
            }
            character => quoted.push(character),
        }
    }
    quoted + "\""
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Vehicle, VehicleFileError> {
        Vehicle::from_toml(text, "mine")
    }

    fn error(text: &str) -> String {
        read(text).unwrap_err().to_string()
    }

    const SIMPLE: &str = "\
search_speed = 500
search_turn_time = 0.25
[along]
acceleration = 6000
top_speed = 3000
[turns]
s90 = { length = 116, speed = 600 }
";

    #[test]
    fn presets_read_back() {
        for name in Vehicle::PRESETS {
            let vehicle = Vehicle::preset(name).unwrap();
            assert_eq!(read(&vehicle.to_toml()), Ok(vehicle.clone()), "{}", vehicle.to_toml());
            let based = read(&format!("name = {name:?}\nbase = {name:?}")).unwrap();
            assert_eq!(based.parameters(), vehicle.parameters());
        }
        let named = "name = 'a \"b\" \\ ü'\nbase = 'ares'\nalong.jerk = 1e6";
        let vehicle = read(named).unwrap();
        assert_eq!(vehicle.name(), "a \"b\" \\ ü");
        assert_eq!(read(&vehicle.to_toml()), Ok(vehicle));
        let vehicle = Vehicle::from_toml(SIMPLE, "a\nb\u{7f}\u{202e}").unwrap();
        assert_eq!(read(&vehicle.to_toml()), Ok(vehicle));
    }

    #[test]
    fn defaults_follow_from_other_values() {
        let simple = read(SIMPLE).unwrap();
        let VehicleParameters {
            name, half_cell, along, diagonal, start_offset, stop_offset, ..
        } = simple.parameters();
        assert_eq!((&**name, *half_cell, *start_offset, *stop_offset), ("mine", 90.0, 45.0, 45.0));
        let expected = StraightLimits {
            acceleration: 6000.0,
            braking: 6000.0,
            top_speed: 3000.0,
            jerk: f64::INFINITY,
        };
        assert_eq!((along, diagonal), (&expected, &None));
        let slower = read("base = 'expert'\nalong.acceleration = 9000\ndiagonal.top_speed = 2000");
        let slower = slower.unwrap();
        let along = slower.limits(false);
        assert_eq!((along.acceleration, along.braking), (9000.0, 9000.0));
        assert_eq!((slower.limits(true).braking, slower.limits(true).top_speed), (17000.0, 2000.0));
        // 2 cells of 180 mm at 500 mm/s, and a turn of 0.25 s.
        assert!((simple.search_time(2, 1) - 0.97).abs() < 1e-12);
        let half = read("base = 'kerise'\ncell = 100\nsearch_turn_time = 0.5").unwrap();
        // 3 cells of 100 mm at 300 mm/s, and 2 turns of 0.5 s.
        assert!((half.search_time(3, 2) - 2.0).abs() < 1e-12);
        let VehicleParameters { start_offset, stop_offset, .. } = half.parameters();
        assert_eq!((*start_offset, *stop_offset), (25.0, 25.0));
        assert!(half.arc(TurnKind::L180).unwrap().arc.length > 200.0);
    }

    #[test]
    fn diagonals_and_turns_of_the_base_can_be_removed() {
        let turns = |vehicle: &Vehicle| -> Vec<&str> {
            vehicle.parameters().turns.iter().map(|(kind, _)| kind.name()).collect()
        };
        let straight = read("base = 'expert'\ndiagonal = false").unwrap();
        assert_eq!(straight.parameters().diagonal, None);
        assert_eq!(turns(&straight), ["s90", "l90", "180"]);
        let fewer = read("base = 'ukmars'\nturns.l90 = false\ndiagonal = false").unwrap();
        assert_eq!(fewer.parameters().turns, Vehicle::ukmars().parameters().turns);
        let fewer = read("base = 'expert'\n[turns]\n45in = false\n180 = false").unwrap();
        assert_eq!(turns(&fewer), ["s90", "l90", "135in", "45out", "135out", "v90"]);
        assert_eq!(fewer.limits(true), Vehicle::expert().limits(true));
    }

    #[test]
    fn faults_name_the_line_and_the_key() {
        insta::assert_snapshot!(error("cell = 180\ncell = 90"), @"line 2: duplicate key");
        insta::assert_snapshot!(error("cell = 180\n\n[along]\nacceleration = fast"), @"line 4: expected a number, false, or a text in quotes");
        insta::assert_snapshot!(error("[along]\nacceleration = 'fast'"), @r#"line 2: invalid type: string "fast", expected a number"#);
        insta::assert_snapshot!(error("[along]\nacelleration = 9000"), @"line 2: unknown field `acelleration`, expected one of `acceleration`, `braking`, `top_speed`, `jerk`");
        insta::assert_snapshot!(error("[turns]\ns90 = { length = 116, speed = 600 }\nl9O = { speed = 3 }"), @"line 3: unknown turn `l9O`, expected one of s90, l90, 180, 45in, 135in, 45out, 135out, v90, k90");
        insta::assert_snapshot!(error("along = 3"), @"line 1: invalid type: integer `3`, expected a table such as { acceleration = 9000, top_speed = 3000 }");
        insta::assert_snapshot!(error("[turns]\nl90 = 900"), @"line 2: invalid type: integer `900`, expected false or a table such as { length = 116, speed = 500 }");
        insta::assert_snapshot!(error("[turns]\nl90 = true"), @"line 2: invalid value: boolean `true`, expected false or a table such as { length = 116, speed = 500 }");
        insta::assert_snapshot!(error("diagonal = true"), @"line 1: invalid value: boolean `true`, expected false or a table such as { acceleration = 9000, top_speed = 3000 }");
        insta::assert_snapshot!(error("[diagonal]\n\nbreaking = 3"), @"line 3: unknown field `breaking`, expected one of `acceleration`, `braking`, `top_speed`, `jerk`");
        insta::assert_snapshot!(error("[along]\nacceleration = quick"), @"line 2: expected a number, false, or a text in quotes");
        insta::assert_snapshot!(error("along.acceleration = 99999999999999999999"), @"line 1: invalid type: integer `99999999999999999999`, expected a number");
        insta::assert_snapshot!(error("turns = [1]"), @"line 1: invalid type: array, expected a table");
        insta::assert_snapshot!(error("base = 'ares'\nname = ' '"), @"line 2: name: expected 1 to 64 characters, found only spaces");
        insta::assert_snapshot!(error(&format!("name = '{}'", "ü".repeat(65))), @"line 1: name: expected 1 to 64 characters, found 65");
        insta::assert_snapshot!(error(&format!("a = {}", "[".repeat(10_000))), @"line 1: cannot recurse further; max recursion depth met");
        insta::assert_snapshot!(error("# mine\nbase = 'export'"), @r#"line 2: base: expected one of ukmars, ares, expert, kerise, found "export""#);
        insta::assert_snapshot!(error(""), @"along.acceleration is missing (set it, or set base to one of ukmars, ares, expert, kerise)");
        insta::assert_snapshot!(error("\n[along]\nacceleration = 6000"), @"line 2: along.top_speed is missing (set it, or set base to one of ukmars, ares, expert, kerise)");
        insta::assert_snapshot!(error("base = 'ukmars'\n[turns]\nl90 = { speed = 900 }"), @r#"line 3: turns.l90.length is missing (set it; base "ukmars" has no value for it)"#);
        insta::assert_snapshot!(error("[along]\nacceleration = 6000\ntop_speed = 3000"), @"search_speed is missing (set it, or set base to one of ukmars, ares, expert, kerise)");
        insta::assert_snapshot!(error("search_speed = 500\n[along]\nacceleration = 6000\ntop_speed = 3000"), @"search_turn_time is missing (set it, or set base to one of ukmars, ares, expert, kerise)");
        insta::assert_snapshot!(error("search_speed = 500\nsearch_turn_time = 0.25\n[along]\nacceleration = 6000\ntop_speed = 3000"), @"turn s90 is missing: without it, a mouse cannot reach every cell");
    }

    #[test]
    fn impossible_values_are_explained() {
        let based = |text: &str| error(&format!("base = 'expert'\n{text}"));
        insta::assert_snapshot!(based("cell = 0.18"), @"line 2: cell: expected 10 to 1000 mm, found 0.18 mm (if it is in m, write 180)");
        insta::assert_snapshot!(based("cell = -180"), @"line 2: cell: expected 10 to 1000 mm, found -180 mm");
        insta::assert_snapshot!(based("start_offset = 100"), @"line 2: start_offset: expected 0 to 90 mm, found 100 mm");
        insta::assert_snapshot!(based("search_speed = 0.6"), @"line 2: search_speed: expected 10 to 20000 mm/s, found 0.6 mm/s (if it is in m/s, write 600)");
        insta::assert_snapshot!(based("search_turn_time = -0.2"), @"line 2: search_turn_time: expected 0 to 10 s, found -0.2 s");
        insta::assert_snapshot!(based("search_turn_time = 200"), @"line 2: search_turn_time: expected 0 to 10 s, found 200 s (if it is in ms, write 0.2)");
        insta::assert_snapshot!(based("along.top_speed = 2.5"), @"line 2: along.top_speed: expected 50 to 20000 mm/s, found 2.5 mm/s (if it is in m/s, write 2500)");
        insta::assert_snapshot!(based("\n[diagonal]\ntop_speed = 2000\nacceleration = 9.81"), @"line 5: diagonal.acceleration: expected 100 to 100000 mm/s², found 9.81 mm/s² (if it is in m/s², write 9810)");
        insta::assert_snapshot!(based("along.acceleration = 1e300"), @"line 2: along.acceleration: expected 100 to 100000 mm/s², found 1e300 mm/s²");
        insta::assert_snapshot!(based("along.braking = nan"), @"line 2: along.braking: expected 100 to 100000 mm/s², found NaN mm/s²");
        insta::assert_snapshot!(based("along.jerk = -inf"), @"line 2: along.jerk: expected 1000 to 1000000000 mm/s³, found -inf mm/s³");
        insta::assert_snapshot!(based("turns.l90.length = -1"), @"line 2: turns.l90.length: expected 1 to 10000 mm, found -1 mm");
        insta::assert_snapshot!(based("turns.l90.speed = 1.6"), @"line 2: turns.l90.speed: expected 10 to 20000 mm/s, found 1.6 mm/s (if it is in m/s, write 1600)");
        insta::assert_snapshot!(based("[turns]\nv90.length = 177\nl90.length = 400"), @"line 4: turn l90 does not fit: its arc of 400 mm is 102.5 mm too long (at most 297.4 mm)");
        insta::assert_snapshot!(based("turns.180.length = 380"), @"line 2: turn 180 does not fit: its arc of 380 mm ends 4.7 mm beyond the centre of the neighbouring cell (expected an arc of 370.31 mm)");
        insta::assert_snapshot!(based("turns.45in.speed = 2600"), @r#"line 2: turn 45in at 2600 mm/s is faster than the top speed of 2500 mm/s along rows and columns; along.top_speed is the value of base "expert""#);
        insta::assert_snapshot!(based("cell = 90"), @r#"line 2: turn s90 does not fit: its arc of 116 mm is 41.6 mm too long (at most 74.3 mm); turns.s90.length is the value of base "expert""#);
        insta::assert_snapshot!(based("along.acceleration = 200"), @r#"line 2: a mouse cannot reach 1050 mm/s, the speed of its slowest turn s90, within 154.8 mm, the distance before the first turn; turns.s90.speed is the value of base "expert""#);
        insta::assert_snapshot!(based("\nalong.top_speed = 1000"), @r#"line 3: turn s90 at 1050 mm/s is faster than the top speed of 1000 mm/s along rows and columns; turns.s90.speed is the value of base "expert""#);
        insta::assert_snapshot!(based("along.top_speed = 6000\nturns.45in.speed = 2600"), @r#"line 3: turn 45in at 2600 mm/s is faster than the top speed of 2500 mm/s on diagonals; diagonal.top_speed is the value of base "expert""#);
        insta::assert_snapshot!(based("start_offset = 0\nalong.acceleration = 4000"), @r#"line 3: a mouse cannot reach 1050 mm/s, the speed of its slowest turn s90, within 109.8 mm, the distance before the first turn; turns.s90.speed is the value of base "expert""#);
        insta::assert_snapshot!(based("along.acceleration = 2500\nalong.braking = 400"), @r#"line 2: a mouse cannot reach 1050 mm/s, the speed of its slowest turn s90, within 154.8 mm, the distance before the first turn; turns.s90.speed is the value of base "expert""#);
        insta::assert_snapshot!(based("turns.s90 = false"), @"line 2: turn s90 is missing: without it, a mouse cannot reach every cell");
        insta::assert_snapshot!(based("diagonal = false\nturns.v90 = { length = 100, speed = 600 }"), @"line 3: turn v90 needs the limits of the mouse on diagonals (set diagonal.acceleration and diagonal.top_speed)");
        insta::assert_snapshot!(error(&format!("{SIMPLE}v90 = {{ length = 100, speed = 600 }}")), @"line 8: turn v90 needs the limits of the mouse on diagonals (set diagonal.acceleration and diagonal.top_speed)");
        insta::assert_snapshot!(error(&SIMPLE.replace("s90", "l90")), @"line 6: turn s90 is missing: without it, a mouse cannot reach every cell");
    }
}
