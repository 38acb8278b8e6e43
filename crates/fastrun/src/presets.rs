//! Mice of real contests.

use alloc::borrow::Cow;

use mmsim_maze::MazeSize;

use crate::planner::is_large;
use crate::straight::StraightLimits;
use crate::turn::TurnKind;
use crate::vehicle::{Arc, Vehicle, VehicleParameters};

/// Returns limits with the same limit for acceleration and braking.
const fn limits(acceleration: f64, top_speed: f64) -> StraightLimits {
    StraightLimits { acceleration, braking: acceleration, top_speed, jerk: f64::INFINITY }
}

fn vehicle(
    name: &'static str,
    half_cell: f64,
    along: StraightLimits,
    diagonal: Option<StraightLimits>,
    turns: &[(TurnKind, f64, f64)],
    (search_speed, search_turn_time): (f64, f64),
) -> Vehicle {
    let turns = turns.iter().map(|&(kind, length, speed)| (kind, Arc { length, speed })).collect();
    let offset = half_cell / 2.0;
    let parameters = VehicleParameters {
        name: Cow::Borrowed(name),
        half_cell,
        along,
        diagonal,
        turns,
        start_offset: offset,
        stop_offset: offset,
        search_speed,
        search_turn_time,
    };
    // A test creates every preset.
    Vehicle::new(parameters).expect("the presets are possible")
}

impl Vehicle {
    /// The names of the presets, slowest first, and the half-size mouse last.
    pub const PRESETS: [&'static str; 4] = ["ukmars", "ares", "expert", "kerise"];

    /// The names of the vehicles that [`default_for`](Self::default_for) returns, for help texts.
    pub const DEFAULTS: &'static str = "expert, in mazes larger than 16×16 kerise";

    /// Returns the vehicle for a maze of this size unless another one is chosen: `expert`, or in mazes
    /// of more than 16 cells in a row or a column the half-size mouse `kerise`.
    ///
    /// ```
    /// use mmsim_fastrun::Vehicle;
    /// use mmsim_maze::MazeSize;
    /// assert_eq!(Vehicle::default_for(MazeSize::CLASSIC), Vehicle::expert());
    /// assert_eq!(Vehicle::default_for(MazeSize::new(9, 17)?), Vehicle::kerise());
    /// # Ok::<(), mmsim_maze::SizeError>(())
    /// ```
    pub fn default_for(size: MazeSize) -> Self {
        if is_large(size) { Self::kerise() } else { Self::expert() }
    }

    /// Returns the preset with this name.
    ///
    /// ```
    /// use mmsim_fastrun::Vehicle;
    /// assert_eq!(Vehicle::preset("ares"), Some(Vehicle::ares()));
    /// assert_eq!(Vehicle::preset("hare"), None);
    /// ```
    pub fn preset(name: &str) -> Option<Self> {
        match name {
            "ukmars" => Some(Self::ukmars()),
            "ares" => Some(Self::ares()),
            "expert" => Some(Self::expert()),
            "kerise" => Some(Self::kerise()),
            _ => None,
        }
    }

    /// Returns a beginner's mouse, which does not drive diagonally: the default fast run of
    /// [mazerunner-core](https://github.com/ukmars/mazerunner-core) by UKMARS, and its search speed
    /// and turns on the spot. The length of its turn is that of [`ares`](Self::ares).
    ///
    /// # Panics
    /// This function and the other presets never panic.
    pub fn ukmars() -> Self {
        let turns = [(TurnKind::S90, 116.0, 500.0)];
        vehicle("ukmars", 90.0, limits(3000.0, 2500.0), None, &turns, (400.0, 0.35))
    }

    /// Returns a hobby mouse: the turns named "APEC 24" of Peter Harrison's
    /// [ares](https://github.com/micromouseonline/ares), each at most as fast as 10 m/s² of
    /// centripetal acceleration allow. The speed of its search is an assumption.
    pub fn ares() -> Self {
        let turns = [
            (TurnKind::S90, 116.0, 500.0),
            (TurnKind::L90, 195.0, 909.0),
            (TurnKind::L180, 370.31, 886.0),
            (TurnKind::In45, 100.0, 850.0),
            (TurnKind::In135, 230.0, 800.0),
            (TurnKind::Out45, 100.0, 850.0),
            (TurnKind::Out135, 220.0, 650.0),
            (TurnKind::V90, 125.0, 600.0),
        ];
        let limits = limits(10_000.0, 5000.0);
        vehicle("ares", 90.0, limits, Some(limits), &turns, (500.0, 0.25))
    }

    /// Returns a contest mouse: the speeds and accelerations that the sixth of an All Japan classic
    /// expert final [published](https://ameblo.jp/paze-paze3241). The lengths follow from its
    /// centripetal acceleration of 2.3 g where they fit; `s90` and the search are assumptions.
    pub fn expert() -> Self {
        let turns = [
            (TurnKind::S90, 116.0, 1050.0),
            (TurnKind::L90, 267.0, 1600.0),
            (TurnKind::L180, 370.31, 1400.0),
            (TurnKind::In45, 102.0, 1400.0),
            (TurnKind::In135, 280.0, 1400.0),
            (TurnKind::Out45, 151.0, 1700.0),
            (TurnKind::Out135, 280.0, 1400.0),
            (TurnKind::V90, 177.0, 1300.0),
        ];
        let limits = limits(17_000.0, 2500.0);
        vehicle("expert", 90.0, limits, Some(limits), &turns, (600.0, 0.2))
    }

    /// Returns a half-size mouse: the parameters of kerikun11's
    /// [micromouse maze library](https://github.com/kerikun11/micromouse-maze-library) and the
    /// reference speeds of his slalom shapes. The lengths follow from the tangents of these shapes.
    /// The values of the search are assumptions near those of his mouse
    /// [KERISE](https://github.com/kerikun11/micromouse-kerise-v4).
    pub fn kerise() -> Self {
        let turns = [
            (TurnKind::S90, 72.7, 266.0),
            (TurnKind::L90, 115.7, 423.0),
            (TurnKind::L180, 185.16, 412.0),
            (TurnKind::In45, 81.4, 412.0),
            (TurnKind::In135, 125.4, 354.0),
            (TurnKind::Out45, 81.4, 412.0),
            (TurnKind::Out135, 125.4, 354.0),
            (TurnKind::V90, 79.3, 290.0),
            (TurnKind::K90, 206.6, 755.0),
        ];
        let diagonal = limits(3600.0, 1200.0);
        vehicle("kerise", 45.0, limits(4200.0, 1500.0), Some(diagonal), &turns, (300.0, 0.25))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_preset_has_its_name_and_fits() {
        for name in Vehicle::PRESETS {
            let vehicle = Vehicle::preset(name).unwrap();
            assert_eq!(vehicle.name(), name);
            for kind in TurnKind::ALL {
                let Some(fitted) = vehicle.arc(kind) else { continue };
                assert!(fitted.before >= 0.0 && fitted.after >= 0.0, "{name} {kind}");
            }
        }
    }
}
