//! What a bake is asked for.

use super::{
    BasisEnergy, CubatureMethod, FineRecipe, HandleRegion, JointLimitKey, Mesher, SoftnessRegion,
    StiffnessRegion, Truncation,
};
use serde::{Deserialize, Serialize};
use supple::material::Material;
use supple::{Error, Result};

/// Every choice of a bake; what is not said has a default. TOML through serde.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Recipe {
    /// What the tissue is made of. Without it a person, whom the bones' names tell, has people's own: G = 750 Pa (breasts
    /// 300), stiffening as Fung's exponential. Others have a stable neo-Hookean tissue, as soft as makes a brisk shake (±5 cm
    /// at 3 Hz) shear the layer's deep parts by some 20 % and move them by about 12 mm at most.
    pub material: Option<Material>,
    /// How soft regions are, and for how long they ring.
    pub softness: Vec<SoftnessRegion>,
    /// For how long all others ring: ζ = 10^(−1.5 bounce) of their first mode, from 0 (not at all) to 1. 0.5 where neither
    /// it nor `damping_time` nor a material is given.
    pub bounce: Option<f64>,
    /// Where the tissue is stiffer or softer than that.
    pub stiffness: Vec<StiffnessRegion>,
    /// Density of tissue and bones, kg/m³.
    pub density: f64,
    /// Stiffness-proportional damping β, s, the same everywhere, in place of what bounce gives; 0.002 where a material is
    /// given and no bounce.
    pub damping_time: Option<f64>,
    /// Whether the rest shape already sags under gravity, as a captured one does.
    pub captured_under_gravity: bool,
    /// Whether what touches the skin pushes back as stiffly as the tissue under it asks for, 100 E/L, in place of 1e8 Pa/m:
    /// wide contact then does not chatter in one iteration, but a small solid sinks in (a ball of 5 cm by 16 mm into a chest).
    pub contact_by_tissue: bool,
    /// Bones a cubature point or node may follow; the skin keeps all of its own.
    pub bones_per_point: usize,
    /// How the layer is meshed, where the body comes without one.
    pub mesher: Mesher,
    /// Where handles stand. Without any they stand over what is soft, 60 to 100 of them by area and depth.
    pub handles: Vec<HandleRegion>,
    /// What the basis minimises: `biharmonic` (k = 2) or `triharmonic` (k = 3).
    pub basis_energy: BasisEnergy,
    /// Truncation of the basis.
    pub truncation: Truncation,
    /// How the tissue is sampled.
    pub cubature: CubatureRecipe,
    /// Handles beside these that sleep until something touches; none where it is not there.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fine_handles: Option<FineRecipe>,
    /// Ranges of joints, in place of the model's own.
    pub limits: Vec<JointLimitKey>,
    /// Whether spring bones of the file (VRM's hair, skirts, tails) swing.
    pub springs: bool,
}

/// How the tissue is sampled. `points` wins over `points_per_handle`, and `all_tets` over both.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CubatureRecipe {
    /// 5 to 10 (method); 10 keeps the cubature within a fifth of the error of all tets.
    pub points_per_handle: f64,
    /// An exact number.
    pub points: Option<usize>,
    /// Every tet becomes a point.
    pub all_tets: bool,
    /// How points are placed and weighted.
    pub method: CubatureMethod,
}

impl Default for CubatureRecipe {
    fn default() -> Self {
        Self {
            points_per_handle: 10.0,
            points: None,
            all_tets: false,
            method: CubatureMethod::default(),
        }
    }
}

impl Default for Recipe {
    fn default() -> Self {
        Self {
            material: None,
            softness: Vec::new(),
            bounce: None,
            stiffness: Vec::new(),
            density: 1000.0,
            damping_time: None,
            captured_under_gravity: true,
            contact_by_tissue: false,
            bones_per_point: 4,
            mesher: Mesher::default(),
            handles: Vec::new(),
            basis_energy: BasisEnergy::default(),
            truncation: Truncation::default(),
            cubature: CubatureRecipe::default(),
            fine_handles: None,
            limits: Vec::new(),
            springs: true,
        }
    }
}

impl Recipe {
    /// Checks the numbers.
    ///
    /// # Errors
    /// [`Error::Invalid`] naming the key.
    pub fn validate(&self) -> Result<()> {
        let positive = |value: f64, field: &str, unit: &str| {
            (value > 0.0 && value.is_finite())
                .then_some(())
                .ok_or_else(|| Error::invalid(field, format!("must be positive{unit}, is {value}")))
        };
        self.material.iter().try_for_each(Material::validate)?;
        for (r, region) in self.stiffness.iter().enumerate() {
            region.validate(&format!("stiffness[{r}]"))?;
        }
        positive(self.density, "density", " (kg/m³)")?;
        positive(
            self.cubature.points_per_handle,
            "cubature.points_per_handle",
            "",
        )?;
        crate::softness::validate(self)?;
        let damping_time = self.damping_time.unwrap_or(0.0);
        if !(damping_time >= 0.0 && damping_time.is_finite()) {
            return Err(Error::invalid(
                "damping_time",
                "must be zero or positive (s)",
            ));
        }
        for (i, key) in self.limits.iter().enumerate() {
            key.range(&format!("limits[{i}]"))?;
        }
        self.fine_handles
            .iter()
            .try_for_each(FineRecipe::validate)?;
        if self.bones_per_point == 0 {
            return Err(Error::invalid("bones_per_point", "must be at least 1"));
        }
        let Truncation { below, above, .. } = self.truncation;
        if !(below >= 0.0 && below < above && above < 1.0) {
            let problem = format!("needs 0 ≤ below < above < 1, has {below} and {above}");
            return Err(Error::invalid("truncation", problem));
        }
        Ok(())
    }

    /// Cubature points for so many handles.
    pub fn points_for(&self, handles: usize) -> usize {
        let asked = (self.cubature.points_per_handle * handles as f64).round() as usize;
        self.cubature.points.unwrap_or(asked.max(5))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn toml_goes_round_and_unknown_keys_are_named() {
        let recipe = Recipe::default();
        let text = toml::to_string(&recipe).unwrap();
        assert_eq!(toml::from_str::<Recipe>(&text).unwrap(), recipe);
        let short = "density = 950.0\n[[handles]]\nbones = [\"palm\"]\nspacing = 0.01\n";
        let read: Recipe = toml::from_str(short).unwrap();
        assert_eq!((read.density, read.handles[0].spacing), (950.0, Some(0.01)));
        let read: Recipe = toml::from_str("[fine_handles]\n").unwrap();
        assert_eq!(read.fine_handles, Some(FineRecipe::default()));
        let shell = "[mesher.prism_shell]\nthickness = 0.01\nlayers = 2\n";
        let read: Recipe = toml::from_str(shell).unwrap();
        assert!(matches!(read.mesher, Mesher::PrismShell(s) if s.layers == Some(2)));
        let error = toml::from_str::<Recipe>("densty = 1.0")
            .unwrap_err()
            .to_string();
        assert!(error.contains("densty"), "{error}");
        let error = toml::from_str::<Recipe>("[[handles]]\nnumber = 3")
            .unwrap_err()
            .to_string();
        assert!(error.contains("number"), "{error}");
    }

    #[test]
    fn bad_numbers_name_their_key() {
        let broken = |change: fn(&mut Recipe)| {
            let mut recipe = Recipe::default();
            change(&mut recipe);
            recipe.validate().unwrap_err().to_string()
        };
        assert!(broken(|r| r.density = f64::NAN).contains("density"));
        assert!(broken(|r| r.damping_time = Some(-1.0)).contains("damping_time"));
        assert!(broken(|r| r.bounce = Some(1.5)).contains("bounce"));
        let both = broken(|r| (r.bounce, r.damping_time) = (Some(0.5), Some(0.01)));
        assert!(both.contains("damping_time"));
        assert!(broken(|r| r.truncation.above = 0.01).contains("truncation"));
        assert!(broken(|r| r.bones_per_point = 0).contains("bones_per_point"));
        let fine = |change: fn(&mut FineRecipe)| {
            let mut fine = FineRecipe::default();
            change(&mut fine);
            fine.validate().unwrap_err().to_string()
        };
        assert!(fine(|f| f.spacing = Some(0.0)).contains("fine_handles.spacing"));
        assert!(fine(|f| f.drop_below = 0.5).contains("fine_handles.drop_below"));
        assert!(fine(|f| f.points_per_handle = f64::NAN).contains("points_per_handle"));
        let asked = Recipe {
            fine_handles: Some(FineRecipe {
                drop_below: 0.5,
                ..FineRecipe::default()
            }),
            ..Recipe::default()
        };
        assert!(asked.validate().is_err());
    }
}
