//! Doubtful vehicles.

use alloc::vec::Vec;

use crate::turn::TurnKind;
use crate::vehicle::Vehicle;

/// The standard acceleration of gravity, 1 g, in mm/s².
pub const STANDARD_GRAVITY: f64 = 9806.65;

/// The greatest centripetal acceleration without a warning, in g. The best mice without suction
/// reach 2.5 g.
const MAX_G: f64 = 3.0;

/// A property of a vehicle that the model accepts, but that is probably a mistake.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum VehicleWarning {
    /// A turn needs a centripetal acceleration that few mice reach.
    #[error(
        "turn {kind} at {speed} mm/s on an arc of {} mm needs {g:.1} g of centripetal \
         acceleration (at {MAX_G} g: {} mm/s)", libm::round(*.length * 100.0) / 100.0, libm::floor(*.limit)
    )]
    FastTurn {
        /// The turn.
        kind: TurnKind,
        /// Its speed, in mm/s.
        speed: f64,
        /// The length of its arc, in mm.
        length: f64,
        /// The centripetal acceleration, in g.
        g: f64,
        /// The speed at 3 g, in mm/s.
        limit: f64,
    },
    /// The mouse has limits for diagonals, but no turn onto them.
    #[error("no turn leads onto diagonals, so the mouse does not drive them (add 45in or 135in)")]
    NoTurnOntoDiagonals,
    /// The mouse has turns onto diagonals, but none off them.
    #[error("no turn leads off diagonals, so the mouse does not drive them (add 45out or 135out)")]
    NoWayOffDiagonals,
}

impl Vehicle {
    /// Returns what is probably a mistake: turns above 3 g of centripetal acceleration, and limits
    /// for diagonals that the mouse cannot reach or leave.
    ///
    /// ```
    /// use mmsim_fastrun::Vehicle;
    /// assert_eq!(Vehicle::expert().warnings(), []);
    /// let vehicle = Vehicle::from_toml("base = 'ares'\nturns.s90.speed = 2000", "fast")?;
    /// assert_eq!(
    ///     vehicle.warnings()[0].to_string(),
    ///     "turn s90 at 2000 mm/s on an arc of 116 mm needs 8.3 g of centripetal acceleration \
    ///      (at 3 g: 1203 mm/s)"
    /// );
    /// # Ok::<(), mmsim_fastrun::VehicleFileError>(())
    /// ```
    pub fn warnings(&self) -> Vec<VehicleWarning> {
        let fast = |kind: TurnKind| {
            let arc = self.arc(kind)?.arc;
            let g = arc.centripetal_acceleration(kind) / STANDARD_GRAVITY;
            let limit = arc.speed_at(kind, MAX_G * STANDARD_GRAVITY);
            let (speed, length) = (arc.speed, arc.length);
            (g > MAX_G).then_some(VehicleWarning::FastTurn { kind, speed, length, g, limit })
        };
        let has = |kinds: [TurnKind; 2]| kinds.iter().any(|&kind| self.arc(kind).is_some());
        let diagonal = self.parameters().diagonal.and_then(|_| {
            if !has([TurnKind::In45, TurnKind::In135]) {
                Some(VehicleWarning::NoTurnOntoDiagonals)
            } else if !has([TurnKind::Out45, TurnKind::Out135]) {
                Some(VehicleWarning::NoWayOffDiagonals)
            } else {
                None
            }
        });
        TurnKind::ALL.into_iter().filter_map(fast).chain(diagonal).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn presets_are_not_doubtful() {
        for name in Vehicle::PRESETS {
            assert_eq!(Vehicle::preset(name).unwrap().warnings(), [], "{name}");
        }
    }

    #[test]
    #[cfg(feature = "std")]
    fn doubtful_vehicles_are_explained() {
        let warnings = |text: &str| -> Vec<String> {
            let vehicle = Vehicle::from_toml(&format!("base = 'expert'\n{text}"), "mine").unwrap();
            vehicle.warnings().iter().map(ToString::to_string).collect()
        };
        insta::assert_debug_snapshot!(warnings("turns.s90.length = 10\nturns.l90.speed = 2500"), @r#"
        [
            "turn s90 at 1050 mm/s on an arc of 10 mm needs 26.5 g of centripetal acceleration (at 3 g: 353 mm/s)",
            "turn l90 at 2500 mm/s on an arc of 267 mm needs 5.6 g of centripetal acceleration (at 3 g: 1825 mm/s)",
        ]
        "#);
        insta::assert_debug_snapshot!(warnings("turns.45in = false\nturns.135in = false"), @r#"
        [
            "no turn leads onto diagonals, so the mouse does not drive them (add 45in or 135in)",
        ]
        "#);
        insta::assert_debug_snapshot!(warnings("turns.45out = false\nturns.135out = false"), @r#"
        [
            "no turn leads off diagonals, so the mouse does not drive them (add 45out or 135out)",
        ]
        "#);
        assert!(warnings("turns.45out = false").is_empty());
        assert!(warnings("diagonal = false").is_empty());
    }
}
