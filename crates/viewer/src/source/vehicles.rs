//! The vehicles whose fast runs a page plays.

use mmsim_fastrun::Vehicle;

use crate::http::api_error::ApiError;

/// The presets, and vehicles of the user. The page selects the user's first one.
///
/// ```
/// use mmsim_fastrun::Vehicle;
/// use mmsim_viewer::Vehicles;
///
/// let mine = Vehicle::from_toml("base = 'expert'\nturns.l90.speed = 1500", "mine")?;
/// let vehicles = Vehicles::new([mine])?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Vehicles {
    all: Vec<Vehicle>,
    selected: Option<String>,
}

/// The error for two different vehicles with the same name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("two vehicles are called {0:?}; set another name in a file")]
pub struct SameName(pub String);

impl Vehicles {
    /// Adds vehicles to the presets.
    ///
    /// # Errors
    /// Returns an error if two different vehicles, including the presets, have the same name.
    pub fn new(own: impl IntoIterator<Item = Vehicle>) -> Result<Self, SameName> {
        let mut vehicles = Self::default();
        for vehicle in own {
            match vehicles.get(vehicle.name()) {
                None => {
                    vehicles.selected.get_or_insert_with(|| vehicle.name().into());
                    vehicles.all.push(vehicle);
                }
                Some(other) if *other == vehicle => {}
                Some(_) => return Err(SameName(vehicle.name().into())),
            }
        }
        Ok(vehicles)
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = &Vehicle> {
        self.all.iter()
    }

    /// Returns the names of all vehicles.
    pub(crate) fn names(&self) -> Vec<String> {
        self.iter().map(|vehicle| vehicle.name().into()).collect()
    }

    /// Returns the name of the vehicle that the page selects, or `None` if a preset fits the maze.
    pub(crate) fn selected(&self) -> Option<String> {
        self.selected.clone()
    }

    fn get(&self, name: &str) -> Option<&Vehicle> {
        self.iter().find(|vehicle| vehicle.name() == name)
    }

    /// Returns the vehicle with this name.
    pub(crate) fn find(&self, name: &str) -> Result<Vehicle, ApiError> {
        self.get(name).cloned().ok_or_else(|| {
            let names = self.names().join(", ");
            ApiError::not_found(format!("no vehicle has the name {name:?} (expected {names})"))
        })
    }
}

impl Default for Vehicles {
    fn default() -> Self {
        let all = Vehicle::PRESETS.into_iter().filter_map(Vehicle::preset).collect();
        Self { all, selected: None }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vehicles_have_different_names() {
        let file =
            |name: &str| Vehicle::from_toml("turns.l90.speed = 1500\nbase = \"expert\"", name);
        let (mine, other) = (file("mine").unwrap(), file("expert").unwrap());
        let vehicles = Vehicles::new([Vehicle::ares(), mine.clone(), mine.clone()]).unwrap();
        assert_eq!(vehicles.names(), ["ukmars", "ares", "expert", "kerise", "mine"]);
        assert_eq!(
            (vehicles.find("mine").unwrap(), &*vehicles.selected().unwrap()),
            (mine, "mine")
        );
        let Err(error) = Vehicles::new([other]) else { panic!("expected an error") };
        assert_eq!(
            error.to_string(),
            r#"two vehicles are called "expert"; set another name in a file"#
        );
    }
}
