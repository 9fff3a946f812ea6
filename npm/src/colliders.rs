//! What an avatar touches.

use crate::avatar::{Core, frame};
use crate::error::{OrThrow, Thrown, invalid};
use serde::Deserialize;
use supple::Error;
use supple::collider::{Collider, Shape};
use wasm_bindgen::prelude::*;

/// What is said of a collider besides its shape and place.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Surface {
    #[serde(default)]
    friction: f64,
    /// Pa/m; none is the tissue's.
    stiffness: Option<f64>,
    #[serde(default)]
    margin: f64,
}

impl Core {
    fn collider(&mut self, number: usize) -> Thrown<&mut Collider> {
        let gone = || invalid("collider", "was removed");
        let key = self.colliders.get(number).copied().flatten();
        self.world.collider_mut(key.ok_or_else(gone)?).or_throw()
    }
}

#[wasm_bindgen]
impl Core {
    /// A collider of a kind with its sizes (m), and the number that it is called by.
    pub fn add_collider(
        &mut self,
        kind: &str,
        sizes: &[f64],
        position: &[f64],
        rotation: &[f64],
        surface: &str,
    ) -> Thrown<usize> {
        let shape = match (kind, sizes) {
            ("sphere", &[radius]) => Shape::Sphere { radius },
            ("capsule", &[radius, half_length]) => Shape::Capsule {
                radius,
                half_length,
            },
            ("cylinder", &[radius, half_length]) => Shape::Cylinder {
                radius,
                half_length,
            },
            ("box", &[x, y, z]) => Shape::Box {
                half_extents: [x, y, z],
            },
            ("halfSpace", &[]) => Shape::HalfSpace,
            _ => {
                let problem = format!("{kind} of {} numbers is none", sizes.len());
                return Err(invalid("collider", problem));
            }
        };
        let surface: Surface = serde_json::from_str(surface).map_err(|e| {
            let problem = e.to_string();
            invalid(
                "collider",
                problem.split(" at line").next().unwrap_or_default(),
            )
        })?;
        let collider = Collider {
            friction: surface.friction,
            stiffness: surface.stiffness,
            margin: surface.margin,
            ..Collider::new(shape, frame(position, rotation)?)
        };
        let key = self.world.add_collider(collider).or_throw()?;
        self.colliders.push(Some(key));
        Ok(self.colliders.len() - 1)
    }

    /// The ground, at height zero.
    pub fn add_ground(&mut self) -> Thrown<usize> {
        let key = self.world.add_ground().or_throw()?;
        self.colliders.push(Some(key));
        Ok(self.colliders.len() - 1)
    }

    /// Where a collider is at the end of the next step; `jump` has it there without a way.
    pub fn move_collider(
        &mut self,
        number: usize,
        position: &[f64],
        rotation: &[f64],
        jump: bool,
    ) -> Thrown<()> {
        let mut moved = frame(position, rotation)?;
        let collider = self.collider(number)?;
        if rotation.is_empty() {
            moved.rotation = collider.frame.rotation;
        }
        collider.frame = moved;
        if jump {
            collider.previous = moved;
        }
        Ok(())
    }

    /// Another μ.
    pub fn set_collider_friction(&mut self, number: usize, friction: f64) -> Thrown<()> {
        let collider = self.collider(number)?;
        let changed = Collider {
            friction,
            ..collider.clone()
        };
        let sound = changed.validate().map_err(|e: Error| e.within("collider"));
        sound.or_throw()?;
        *collider = changed;
        Ok(())
    }

    /// Takes a collider out.
    pub fn remove_collider(&mut self, number: usize) -> Thrown<()> {
        let key = self.colliders.get_mut(number).and_then(Option::take);
        let key = key.ok_or_else(|| invalid("collider", "was removed before"))?;
        self.world.remove_collider(key).or_throw()?;
        Ok(())
    }
}
