//! Vehicles named on the command line.

use std::io::ErrorKind;

use mmsim_fastrun::{LoadVehicleError, Vehicle};
use mmsim_maze::Escaped;

use crate::args::extension;
use crate::output::warn;

/// The possible values of `--vehicle`, for its help.
pub(crate) const VEHICLES: &str =
    "ukmars (beginner), ares (hobby), expert (contest), kerise (half-size), or a TOML file";

/// Returns the help of the vehicles of a command that also shows the viewer page.
pub(crate) fn timing_vehicle_help() -> String {
    let default = Vehicle::DEFAULTS;
    format!(
        "Vehicle that times the runs, also on the viewer page: {VEHICLES}; may be repeated to add \
         further ones to the page [default: {default}]"
    )
}

const NOT_TOML: &str = "expected the name of a vehicle or a TOML file, found another file";

/// Parses a value of `--vehicle`: the name of a preset, or a TOML file.
pub(crate) fn parse_vehicle(text: &str) -> Result<Vehicle, String> {
    Vehicle::load(text).map_err(|error| match error {
        LoadVehicleError::Read { source, .. } => {
            let hint = match source.kind() {
                ErrorKind::NotFound => {
                    " (mmsim fast-run --print-vehicle --vehicle expert prints a file to start from)"
                }
                _ => "",
            };
            match source.kind() {
                ErrorKind::InvalidData => format!("{NOT_TOML}: {source}"),
                _ => format!("cannot read the file: {source}{hint}"),
            }
        }
        LoadVehicleError::Invalid { path, source } if extension(&path) != "toml" => {
            format!("{NOT_TOML}: {source}")
        }
        LoadVehicleError::Invalid { source, .. } => source.to_string(),
        _ => unknown(text),
    })
}

/// A vehicle with the argument of `--vehicle` that names it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct GivenVehicle {
    pub(crate) argument: String,
    pub(crate) vehicle: Vehicle,
}

/// Parses a value of `--vehicle`, and keeps the argument.
pub(crate) fn parse_given_vehicle(text: &str) -> Result<GivenVehicle, String> {
    match parse_vehicle(text) {
        Ok(vehicle) => Ok(GivenVehicle { argument: text.into(), vehicle }),
        Err(error) if text.contains(',') => {
            Err(format!("{error} (repeat --vehicle for several vehicles)"))
        }
        Err(error) => Err(error),
    }
}

/// Returns the vehicles that were given, each once. Returns an error if two have the same name.
pub(crate) fn each_vehicle_once(given: &[GivenVehicle]) -> Result<Vec<Vehicle>, String> {
    let mut vehicles: Vec<&GivenVehicle> = Vec::new();
    for one in given {
        let (name, vehicle) = (one.vehicle.name(), &one.vehicle);
        match vehicles.iter().find(|other| other.vehicle.name() == name) {
            None => vehicles.push(one),
            Some(other) if other.vehicle == *vehicle => {}
            Some(other) => {
                return Err(format!(
                    "{} and {} are both called {name:?} (set another name in one of the files, such as \
                     name = \"my mouse\")",
                    Escaped(&other.argument),
                    Escaped(&one.argument)
                ));
            }
        }
    }
    Ok(vehicles.into_iter().map(|given| given.vehicle.clone()).collect())
}

/// Prints what is probably a mistake in a vehicle.
pub(crate) fn warn_about(vehicle: &Vehicle) {
    for warning in vehicle.warnings() {
        warn(format_args!("mmsim: warning: {}: {warning}", vehicle.name()));
    }
}

fn unknown(name: &str) -> String {
    let mut presets = Vehicle::PRESETS.iter();
    let similar = presets.find(|preset| strsim::damerau_levenshtein(name, preset) <= 2);
    let hint = similar.map(|preset| format!(" (did you mean {preset}?)")).unwrap_or_default();
    format!("expected {} or a TOML file{hint}", Vehicle::PRESETS.join(", "))
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn names_and_files_are_vehicles() {
        assert_eq!(parse_vehicle("ares"), Ok(Vehicle::ares()));
        let error = |text: &str| parse_vehicle(text).unwrap_err();
        insta::assert_snapshot!(error("exprt"), @"expected ukmars, ares, expert, kerise or a TOML file (did you mean expert?)");
        insta::assert_snapshot!(error("bicycle"), @"expected ukmars, ares, expert, kerise or a TOML file");
        assert!(error("no/such/file").starts_with("cannot read the file: "));
        assert!(error("none.toml").ends_with(
            "(mmsim fast-run --print-vehicle --vehicle expert prints a file to start from)"
        ));
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("my mouse.toml");
        let text = |content: &str| {
            fs::write(&file, content).unwrap();
            parse_vehicle(&file.display().to_string())
        };
        let vehicle = text("base = 'expert'\nalong.top_speed = 4000").unwrap();
        assert_eq!((vehicle.name(), vehicle.limits(false).top_speed), ("my mouse", 4000.0));
        assert_eq!(text("base = 'expert'\nname = 'fast'").unwrap().name(), "fast");
        assert!(text("\nbase = 1").unwrap_err().starts_with("line 2: "));
        assert!(text(&"#".repeat(2 << 20)).unwrap_err().ends_with("larger than 1 MiB"));
        fs::write(&file, [0xff]).unwrap();
        assert!(parse_vehicle(&file.display().to_string()).unwrap_err().contains("UTF-8"));
        let mouse = folder.path().join("my-mouse");
        for content in [&b"\x7fELF\x02\xff"[..], b"#!/bin/sh\nexit 1\n"] {
            fs::write(&mouse, content).unwrap();
            assert!(error(&mouse.display().to_string()).starts_with(&format!("{NOT_TOML}: ")));
        }
        assert!(error(&folder.path().display().to_string()).starts_with("cannot read the file: "));
    }

    #[test]
    fn each_name_stands_for_one_vehicle() {
        let given = ["expert", "ares", "expert"].map(|name| parse_given_vehicle(name).unwrap());
        assert_eq!(each_vehicle_once(&given), Ok(vec![Vehicle::expert(), Vehicle::ares()]));
        let list = parse_given_vehicle("expert,ares").unwrap_err();
        insta::assert_snapshot!(list, @"expected ukmars, ares, expert, kerise or a TOML file (repeat --vehicle for several vehicles)");
        let [expert, ..] = given;
        let other = Vehicle::from_toml("base = 'ares'\nname = 'expert'", "").unwrap();
        let other = GivenVehicle { argument: "other.toml".into(), vehicle: other };
        let error = each_vehicle_once(&[expert, other]).unwrap_err();
        insta::assert_snapshot!(error, @r#"expert and other.toml are both called "expert" (set another name in one of the files, such as name = "my mouse")"#);
    }
}
