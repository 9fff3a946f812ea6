//! What may be set while it runs, by name.

use crate::avatar::Core;
use crate::error::{OrThrow, Thrown};
use serde_json::{Map, Value};
use supple::glam::DVec3;
use supple::potential::TissueFactors;
use supple::sim::Settings;
use supple::{Error, Result};
use wasm_bindgen::prelude::*;

/// Factors on the tissue.
const FACTORS: [&str; 6] = [
    "softness",
    "bounce",
    "tension",
    "friction",
    "tissueGravity",
    "gravity",
];

/// What is set at present, with `given` over it.
struct Changes {
    factors: TissueFactors,
    gravity: DVec3,
    settings: Settings,
}

fn number(field: &str, value: &Value) -> Result<f64> {
    value
        .as_f64()
        .ok_or_else(|| Error::invalid(field, format!("{value} is no number")))
}

/// A number is how strong it is, against the world's up.
fn gravity(value: &Value, up: DVec3) -> Result<DVec3> {
    if let Some(strength) = value.as_f64() {
        return Ok(-strength * up);
    }
    let parts = value.as_array().map(|parts| {
        let parts = parts.iter().map(Value::as_f64);
        parts.collect::<Option<Vec<f64>>>()
    });
    match parts.flatten().as_deref() {
        Some(&[x, y, z]) => Ok(DVec3::new(x, y, z)),
        _ => {
            let problem = format!("{value} is neither a number nor three of them (m/s²)");
            Err(Error::invalid("gravity", problem))
        }
    }
}

/// `longestStep` is `longest_step` here and in scenes.
fn in_snake_case(key: &str) -> String {
    let mut out = String::new();
    for letter in key.chars() {
        if letter.is_ascii_uppercase() {
            out.push('_');
        }
        out.push(letter.to_ascii_lowercase());
    }
    out
}

/// A solver by its name, or as it is.
fn solver(value: &Value) -> Value {
    match value {
        Value::String(name) => serde_json::json!({ "mode": in_snake_case(name) }),
        other => other.clone(),
    }
}

impl Changes {
    fn take(&mut self, given: &Map<String, Value>, up: DVec3) -> Result<()> {
        let unreadable = |e: serde_json::Error| Error::invalid("settings", e.to_string());
        let mut table = match serde_json::to_value(self.settings).map_err(unreadable)? {
            Value::Object(table) => table,
            _ => Map::new(),
        };
        table.remove("time_step");
        for (key, value) in given {
            match key.as_str() {
                "softness" => {
                    let softness = number(key, value)?;
                    if !(softness > 0.0 && softness.is_finite()) {
                        let problem = format!(
                            "{softness}; must be positive (1 is as it was baked, 2 is twice as soft)"
                        );
                        return Err(Error::invalid("softness", problem));
                    }
                    self.factors.stiffness = softness.recip();
                }
                "bounce" => self.factors.set_bounce(number(key, value)?)?,
                "tension" => self.factors.tension = number(key, value)?,
                "friction" => self.factors.friction = number(key, value)?,
                "tissueGravity" => self.factors.gravity = number(key, value)?,
                "gravity" => self.gravity = gravity(value, up)?,
                "integrator" | "solver" => {
                    let value = match (key.as_str(), value) {
                        ("solver", value) => solver(value),
                        (_, Value::String(name)) => Value::String(in_snake_case(name)),
                        (_, other) => other.clone(),
                    };
                    table.insert(key.clone(), value);
                }
                _ if table.contains_key(&in_snake_case(key)) => {
                    table.insert(in_snake_case(key), value.clone());
                }
                _ => {
                    let known = table.keys().map(String::as_str);
                    let known: Vec<&str> = FACTORS.into_iter().chain(known).collect();
                    let problem = format!("is no setting; there are {}", known.join(", "));
                    return Err(Error::invalid(key.as_str(), problem));
                }
            }
        }
        self.settings = serde_json::from_value(Value::Object(table)).map_err(unreadable)?;
        self.settings.validate()?;
        self.factors.validate()
    }
}

#[wasm_bindgen]
impl Core {
    /// Sets what the JSON object names; all of it or nothing.
    pub fn set(&mut self, json: &str) -> Thrown<()> {
        let given: Map<String, Value> = serde_json::from_str(json)
            .map_err(|e| Error::invalid("settings", e.to_string()))
            .or_throw()?;
        let up = self.world.up().direction();
        let mut changes = Changes {
            factors: self.character()?.instance().factors,
            gravity: self.world.gravity(),
            settings: *self.world.settings(),
        };
        changes.take(&given, up).or_throw()?;
        self.world.set_settings(changes.settings).or_throw()?;
        self.world.set_gravity(changes.gravity);
        self.character()?.set_factors(changes.factors).or_throw()
    }
}
