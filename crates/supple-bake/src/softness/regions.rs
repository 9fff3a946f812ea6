//! The regions of a body and their moduli: what a recipe says, what is chosen, and what the reduced tissue makes of it.
//!
//! ```text
//! G = G₀ Π_r (G_r/G₀)^w_r    β = Π_r β_r^w_r    β_r = ζ_r/(π f_r)
//! ```
//!
//! with w_r a partition of unity over the tets and f_r the frequency of r's sway in the reduced tissue ([`RestSystem`]). A wanted
//! f_r scales G_r by (wanted/found)², round after round, as neighbours yield.

use super::person::Person;
use super::recipe::{SoftnessRegion, check_bounce};
use super::{BodyRegion, RegionReport};
use crate::body::{Body, LayerMesh};
use crate::handles::{Softness, automatic, upper_quantile};
use crate::math::NearestPoint;
use crate::sway::{RestSystem, sway_frequency};
use crate::{Recipe, Tissue};
use glam::DVec3;
use std::f64::consts::{PI, TAU};
use supple::internal::math::{Rows, par_map};
use supple::material::{
    DEFAULT_BOUNCE, FungNeoHookean, LocalTissue, Material, damping_ratio, damping_time,
};
use supple::model::{Avatar, BasisEntry, SkinWeight};
use supple::{Error, Result};

/// G of a person's fat and relaxed muscle, Pa: abs(G*) at small strains by MR elastography.
const PERSON: f64 = 750.0;
/// The same of breasts, Pa: softer ones than that (300 Pa are measured) turn narrow tets under the tips inside out when a body
/// is shaken by ±5 cm at 3 Hz.
const BREAST: f64 = 550.0;
/// b of a person's tissue: shaken like that, no tet of the sample body and of a MakeHuman body inverts (det F 0.36 where all bones
/// follow, 0.03 where they hang limp), and tissue moves by 16 to 26 mm at most. With 10 the limp one reaches −0.3.
const STIFFENING: f64 = 25.0;
/// Poisson's ratio of a person's tissue.
const POISSONS_RATIO: f64 = 0.4;
/// β, s, of a material that the recipe names, where it says nothing of damping.
const DAMPING_TIME: f64 = 0.002;
/// The part of a region's depth, from the skin, that is fat where there is muscle, and the width of the change.
const FAT: [f64; 2] = [0.4, 0.2];
/// What counts as a region's deep part, of its skin's area.
const DEEPEST_AREA: f64 = 0.15;
/// Rounds of scaling, and how near frequencies come.
const ROUNDS: usize = 20;
const NEAR: f64 = 2e-3;
/// κ of a layer between a plane and a cone, for a first guess.
const KAPPA: f64 = 2.0;

/// A region and how soft it is.
#[derive(Clone, Debug)]
struct Region {
    report: RegionReport,
    /// Its part in each tet.
    weights: Vec<f64>,
    /// The recipe's name for it, where it speaks of it.
    field: Option<String>,
    /// Hz; the modulus follows.
    wanted: Option<f64>,
    bounce: f64,
    damping_time: f64,
}

/// The regions of a body.
#[derive(Clone, Debug)]
pub(crate) struct Regions {
    list: Vec<Region>,
    /// What the bake or the recipe makes the tissue of.
    pub material: Material,
    /// Its G₀, Pa.
    shear_modulus: f64,
    /// Whether damping follows from bounce; else β is this.
    damping_time: Option<f64>,
    /// Of each tet.
    muscle: Vec<f64>,
}

impl Regions {
    /// Of `body`, by `recipe`; `selected` is the share of each of its softness regions in each tet.
    ///
    /// # Errors
    /// [`Error::Invalid`] of a region that is not there or holds no tissue.
    pub fn new(
        body: &Body,
        recipe: &Recipe,
        depth: &Softness,
        node_skinning: &Rows<SkinWeight>,
        selected: &[Vec<f64>],
    ) -> Result<Self> {
        let layer = &body.layer;
        let person = Person::of(body);
        let of_person = recipe.material.is_none() && person.is_some();
        let material = match recipe.material {
            Some(material) => material,
            None if of_person => Material::FungNeoHookean(FungNeoHookean {
                stiffening: STIFFENING,
                ..FungNeoHookean::from_shear_modulus(PERSON, POISSONS_RATIO)
            }),
            None => automatic::material(depth, recipe.density),
        };
        let shear_modulus = material.shear_modulus();
        let by_bounce = recipe.bounce.is_some()
            || (recipe.material.is_none() && recipe.damping_time.is_none())
            || recipe.softness.iter().any(|r| r.bounce.is_some());
        let shares = person.as_ref().map(|person| {
            let in_tets = par_map(layer.mesh.tets.len(), |t| {
                let rows = layer.mesh.tets[t].map(|n| node_skinning.row(n as usize));
                let bones: Vec<SkinWeight> = (rows.iter().flat_map(|row| row.iter()))
                    .map(|w| SkinWeight {
                        bone: w.bone,
                        weight: 0.25 * w.weight,
                    })
                    .collect();
                person.shares(layer.mesh.centroid(t), &bones)
            });
            let skin = body.skin.positions.iter().zip(body.skinning.iter());
            let on_skin: Vec<[f64; 5]> = skin.map(|(p, row)| person.shares(*p, row)).collect();
            (in_tets, on_skin)
        });
        let tets = layer.mesh.tets.len();
        let mut regions = Self {
            list: Vec::new(),
            material,
            shear_modulus,
            damping_time: (!by_bounce).then(|| recipe.damping_time.unwrap_or(DAMPING_TIME)),
            muscle: vec![0.0; tets],
        };
        let bounce = recipe.bounce.unwrap_or(DEFAULT_BOUNCE);
        let nothing_else = !of_person && recipe.softness.is_empty();
        let rest = if nothing_else { "tissue" } else { "elsewhere" };
        let chosen = recipe.material.is_none();
        regions.list.push(Region::new(
            rest,
            chosen,
            shear_modulus,
            bounce,
            vec![1.0; tets],
        ));
        if let Some((in_tets, _)) = shares.as_ref().filter(|_| of_person) {
            for (k, part) in BodyRegion::ALL.into_iter().enumerate() {
                let modulus = if part == BodyRegion::Breast {
                    BREAST
                } else {
                    PERSON
                };
                let share = in_tets.iter().map(|s| s[k]).collect();
                regions.push(Region::new(part.name(), true, modulus, bounce, share));
            }
            regions.muscle = muscle(layer, &body.skin.positions, in_tets);
        }
        for (r, asked) in recipe.softness.iter().enumerate() {
            let field = format!("recipe.softness[{r}]");
            let part = match (asked.part, &shares) {
                (None, _) => None,
                (Some(part), Some((in_tets, _))) => {
                    let k = BodyRegion::ALL.iter().position(|p| *p == part);
                    k.map(|k| in_tets.iter().map(|s| s[k]).collect::<Vec<f64>>())
                }
                (Some(part), None) => {
                    let problem = format!(
                        "the bones' names tell no person, so that {} is nowhere: name bones, a box or a painted map",
                        part.name()
                    );
                    return Err(Error::invalid(format!("{field}.part"), problem));
                }
            };
            let known = (regions.list.iter_mut())
                .find(|known| asked.part.is_some_and(|p| p.name() == known.report.name));
            match known.filter(|_| !asked.is_selected()) {
                Some(known) => known.ask(asked, field),
                None => {
                    let mut share = selected[r].clone();
                    if let Some(part) = part {
                        share.iter_mut().zip(part).for_each(|(s, p)| *s *= p);
                    }
                    let mut region =
                        Region::new(&asked.name(), chosen, shear_modulus, bounce, share);
                    region.ask(asked, field);
                    regions.push(region);
                }
            }
        }
        regions.measure(body, recipe, depth)?;
        Ok(regions)
    }

    /// Adds a region that takes its share of all that there is so far.
    fn push(&mut self, region: Region) {
        for known in &mut self.list {
            for (own, taken) in known.weights.iter_mut().zip(&region.weights) {
                *own *= 1.0 - taken;
            }
        }
        self.list.push(region);
    }

    /// Fills in masses, depths and muscle, guesses moduli from wanted frequencies, and drops chosen regions without tissue.
    fn measure(&mut self, body: &Body, recipe: &Recipe, depth: &Softness) -> Result<()> {
        let layer = &body.layer;
        let tissue = Tissue {
            mesh: &layer.mesh,
            fraction: &layer.tissue_fraction,
        };
        let volumes = tissue.tet_volumes();
        let whole: f64 = volumes.iter().sum();
        let areas = body.skin.vertex_areas();
        for region in &mut self.list {
            let volume: f64 = volumes
                .iter()
                .zip(&region.weights)
                .map(|(v, w)| v * w)
                .sum();
            let muscle = volumes.iter().zip(&region.weights).zip(&self.muscle);
            let muscle: f64 = muscle.map(|((v, w), m)| v * w * m).sum();
            region.report.mass = recipe.density * volume;
            region.report.muscle = if volume > 0.0 { muscle / volume } else { 0.0 };
            // A node's share is the mean of the tets around it, a vertex's that of its nodes.
            let mut at_nodes = vec![(0.0, 0.0); layer.mesh.nodes.len()];
            for (tet, w) in layer.mesh.tets.iter().zip(&region.weights) {
                for &n in tet {
                    let (sum, count) = &mut at_nodes[n as usize];
                    (*sum, *count) = (*sum + w, *count + 1.0);
                }
            }
            let on_skin: Vec<f64> = (areas.iter().zip(layer.skin_embedding.iter()))
                .map(|(area, row)| {
                    let share = |&(n, share): &(u32, f64)| {
                        let (sum, count) = at_nodes[n as usize];
                        share * sum / f64::max(count, 1.0)
                    };
                    // Most of it, so that a neighbour's depth does not count.
                    let share: f64 = row.iter().map(share).sum();
                    if share > 0.5 { area * share } else { 0.0 }
                })
                .collect();
            let deep = upper_quantile(&depth.depth, &on_skin, DEEPEST_AREA);
            region.report.depth = if deep.is_finite() { deep } else { 0.0 };
            if let Some(field) = &region.field
                && region.report.mass <= 1e-6 * recipe.density * whole
            {
                let problem = format!("no tissue lies in {}: widen it", region.report.name);
                return Err(Error::invalid(field, problem));
            }
            if let Some(wanted) = region.wanted {
                let speed = TAU * region.report.depth.max(1e-3) * wanted / KAPPA;
                region.report.shear_modulus = recipe.density * speed * speed;
            }
        }
        Ok(())
    }

    /// Whether anything is to be found out about frequencies.
    fn is_asked(&self) -> bool {
        self.damping_time.is_none() || self.list.iter().any(|r| r.wanted.is_some())
    }

    /// `base` of tets with the regions' moduli, damping and muscle.
    pub fn on(&self, base: &[LocalTissue]) -> Vec<LocalTissue> {
        let of_tet = |t: usize| {
            let (mut stiffness, mut damping) = (0.0, 0.0);
            for region in &self.list {
                let ratio = region.report.shear_modulus / self.shear_modulus;
                stiffness += region.weights[t] * ratio.ln();
                damping += region.weights[t] * region.damping_time.max(f64::MIN_POSITIVE).ln();
            }
            LocalTissue {
                stiffness: base[t].stiffness * stiffness.exp(),
                damping_time: self.damping_time.unwrap_or(damping.exp()),
                muscle: self.muscle[t],
                ..base[t]
            }
        };
        par_map(base.len(), of_tet)
    }

    /// Scales moduli until `avatar`, whose points are the centroids of `tets`, has the frequencies that are wanted, and finds
    /// the damping of all regions. `base` is what [`Regions::on`] starts from.
    ///
    /// # Errors
    /// [`Error::Solve`] where a wanted frequency is not reached.
    pub fn calibrate(
        &mut self,
        avatar: &mut Avatar,
        tets: &[u32],
        base: &[LocalTissue],
    ) -> Result<()> {
        if self.is_asked() {
            let wanted = self.list.iter().any(|r| r.wanted.is_some());
            match self.find_frequencies(avatar, tets, base) {
                Err(error) if wanted => return Err(error),
                // Nothing hangs on them but how long it rings.
                Err(_) => self.guess_frequencies(avatar.density),
                Ok(()) => {}
            }
        }
        for region in &mut self.list {
            let f1 = region.report.frequency;
            region.damping_time = match f1 > 0.0 {
                true => damping_time(region.bounce, f1),
                false => DAMPING_TIME,
            };
            region.report.damping_ratio = match self.damping_time {
                Some(time) => PI * f1 * time,
                None => damping_ratio(region.bounce),
            };
        }
        avatar.layer.tissue = self.on(base);
        avatar.tissue = tets
            .iter()
            .map(|&t| avatar.layer.tissue[t as usize])
            .collect();
        Ok(())
    }

    fn find_frequencies(
        &mut self,
        avatar: &mut Avatar,
        tets: &[u32],
        base: &[LocalTissue],
    ) -> Result<()> {
        for _ in 0..ROUNDS {
            let tissue = self.on(base);
            avatar.tissue = tets.iter().map(|&t| tissue[t as usize]).collect();
            let sway = sway_of_points(avatar)?;
            let mut off: f64 = 0.0;
            for region in &mut self.list {
                let points = sway.iter().zip(tets);
                let own = points.map(|((mass, u), &t)| (mass * region.weights[t as usize], *u));
                let frequency = sway_frequency(own);
                region.report.frequency = frequency;
                if let Some(wanted) = region.wanted {
                    if frequency <= 0.0 {
                        let problem = format!(
                            "no handle moves {}: handles must stand there",
                            region.report.name
                        );
                        let field = region.field.clone().unwrap_or_default();
                        return Err(Error::invalid(field, problem));
                    }
                    off = off.max((frequency / wanted - 1.0).abs());
                }
            }
            if off <= NEAR {
                return Ok(());
            }
            for region in &mut self.list {
                if let Some(wanted) = region.wanted {
                    // A neighbour that is much stiffer holds it: one round must not throw a region far.
                    let ratio = (wanted / region.report.frequency).powi(2);
                    region.report.shear_modulus *= ratio.clamp(0.25, 4.0);
                }
            }
        }
        let off = |r: &&Region| {
            r.wanted
                .is_some_and(|f| (r.report.frequency / f - 1.0).abs() > 0.05)
        };
        match self.list.iter().find(off) {
            None => Ok(()),
            Some(region) => Err(Error::Solve {
                system: "softness by frequency",
                problem: format!(
                    "{} comes to {:.2} Hz in place of {:.2}: what is around it is too stiff or too soft",
                    region.report.name,
                    region.report.frequency,
                    region.wanted.unwrap_or_default()
                ),
            }),
        }
    }

    /// f₁ of a layer as deep as each region: κ √(G/ρ)/(2π L).
    fn guess_frequencies(&mut self, density: f64) {
        for RegionReport {
            frequency,
            shear_modulus,
            depth,
            ..
        } in self.list.iter_mut().map(|r| &mut r.report)
        {
            *frequency = match *depth > 0.0 {
                true => KAPPA * (*shear_modulus / density).sqrt() / (TAU * *depth),
                false => 0.0,
            };
        }
    }

    /// What is told of each that has tissue.
    pub fn reports(&self) -> Vec<RegionReport> {
        let whole: f64 = self.list.iter().map(|r| r.report.mass).sum();
        let told = self.list.iter().filter(|r| r.report.mass > 1e-3 * whole);
        told.map(|r| r.report.clone()).collect()
    }
}

impl Region {
    fn new(name: &str, chosen: bool, shear_modulus: f64, bounce: f64, weights: Vec<f64>) -> Self {
        Self {
            report: RegionReport {
                name: name.into(),
                chosen,
                shear_modulus,
                ..RegionReport::default()
            },
            weights,
            field: None,
            wanted: None,
            bounce,
            damping_time: DAMPING_TIME,
        }
    }

    /// Takes what a recipe says.
    fn ask(&mut self, asked: &SoftnessRegion, field: String) {
        self.field = Some(field);
        self.wanted = asked.f1;
        self.bounce = asked.bounce.unwrap_or(self.bounce);
        if let Some(modulus) = asked.shear_modulus {
            self.report.shear_modulus = modulus;
        }
        self.report.chosen &= asked.f1.is_none() && asked.shear_modulus.is_none();
    }
}

/// Checks a recipe's numbers.
pub(crate) fn validate(recipe: &Recipe) -> Result<()> {
    for (r, region) in recipe.softness.iter().enumerate() {
        region.validate(&format!("softness[{r}]"))?;
    }
    check_bounce(recipe.bounce, "bounce")?;
    if recipe.bounce.is_some() && recipe.damping_time.is_some() {
        let problem = "follows from bounce: leave one of the two out";
        return Err(Error::invalid("damping_time", problem));
    }
    Ok(())
}

/// Mass, kg, and u, m, of each cubature point under 1 m/s² along x, y and z.
fn sway_of_points(avatar: &Avatar) -> Result<Vec<(f64, [DVec3; 3])>> {
    let handles = RestSystem::of(avatar).sway()?;
    let points = &avatar.cubature;
    let of_point = |(row, measure): (&[BasisEntry], &f64)| {
        let u = |along: &Vec<DVec3>| row.iter().map(|u| u.value * along[u.handle as usize]).sum();
        (avatar.density * measure, [0, 1, 2].map(|d| u(&handles[d])))
    };
    Ok(points
        .basis
        .iter()
        .zip(&points.measure)
        .map(of_point)
        .collect())
}

/// Share of muscle in each tet: thighs and calves below their fat.
fn muscle(layer: &LayerMesh, skin: &[DVec3], shares: &[[f64; 5]]) -> Vec<f64> {
    let mesh = &layer.mesh;
    let held: Vec<DVec3> = (mesh.nodes.iter().zip(&layer.bone_of_node))
        .filter_map(|(place, bone)| bone.map(|_| *place))
        .collect();
    let (bone, skin) = (NearestPoint::new(&held), NearestPoint::new(skin));
    par_map(mesh.tets.len(), |t| {
        let own = BodyRegion::ALL.iter().zip(&shares[t]);
        let share: f64 = own.filter(|(p, _)| p.has_muscle()).map(|(_, s)| s).sum();
        if share == 0.0 {
            return 0.0;
        }
        let place = mesh.centroid(t);
        let (above, below) = (skin.distance(place), bone.distance(place));
        let part = above / (above + below).max(f64::MIN_POSITIVE);
        let s = ((part - FAT[0]) / FAT[1] + 0.5).clamp(0.0, 1.0);
        // Shares add up to one but for rounding.
        (share * s * s * (3.0 - 2.0 * s)).min(1.0)
    })
}
