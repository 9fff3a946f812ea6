//! How far f32 may be from the materials' stress, tangent and energy: their formulas on absolute values, with all
//! signs plus, and how many roundings a term sees.

use super::bound::{QUOTIENT, ROOT, abs, abs_cofactor, abs_determinant, abs_trace};
use supple::glam::{DMat3, DVec3};
use supple::internal::math::double_dot;
use supple::material::{FungNeoHookean, Material, MaterialPoint, Orthotropic};

/// An entry turned by a Jacobi rotation: a product and a sum; c = 1/√(t² + 1) and s = t c, so that what is turned grows by
/// the error of c; and what stays behind where t, two quotients and a root, is off.
const ROTATION: usize = 2 + (2 + ROOT + QUOTIENT) + (2 + ROOT + 2 * QUOTIENT);

fn size(m: DMat3) -> f64 {
    m.to_cols_array().iter().map(|x| x * x).sum::<f64>().sqrt()
}

fn by_entries(a: DMat3, b: DMat3) -> DMat3 {
    DMat3::from_cols(
        a.x_axis * b.x_axis,
        a.y_axis * b.y_axis,
        a.z_axis * b.z_axis,
    )
}

/// β/h under tension: a product and a sum, the root, its quotient, and two products.
pub const DAMPING_RATE: usize = 2 + ROOT + QUOTIENT + 2;

/// Magnitudes at a point from |H| and, for energies, |D|.
pub struct Magnitudes<'a> {
    tissue: MaterialPoint<'a>,
    mu: f64,
    lambda: f64,
    /// F, and |H| with all signs plus.
    f: DMat3,
    h: DMat3,
    fibres: Option<Fibres>,
    stiffening: Option<Stiffening>,
}

/// What stiffening makes of μ.
struct Stiffening {
    model: FungNeoHookean,
    /// y = b Q, and Q with all signs plus.
    y: f64,
    strain: f64,
}

impl Stiffening {
    /// Roundings of g″ and g′ besides those of y, which has no more than a stress: the exponential (3 + 2 |x| ulp, |x| up to
    /// y_max ≤ 4, an ulp two roundings), sums and products. Of a difference: two exponentials, one of them over its argument and
    /// less one (at arguments above ½ that costs a factor of 2.6), the quotient of the share, ten products and sums.
    const ROUNDINGS: usize = 22 + 6;
    const DIFFERENCE_ROUNDINGS: usize = 22 + 3 * 22 + 2 * QUOTIENT + 10;

    fn new(model: FungNeoHookean, h: DMat3, abs_h: DMat3) -> Self {
        let f = DMat3::IDENTITY + h;
        let j = f.determinant();
        let higher = abs_trace(abs_cofactor(abs_h)) + abs_determinant(abs_h);
        let volume = abs_trace(abs_h) + higher;
        Self {
            model,
            y: model.stiffening * (double_dot(f, f) - 4.0 * j + j * j),
            strain: double_dot(abs_h, abs_h) + 2.0 * higher + volume * volume,
        }
    }

    fn second(&self) -> f64 {
        self.y.min(self.model.stiffening_limit).exp()
    }

    /// g′.
    fn first(&self) -> f64 {
        self.second() * (1.0 + (self.y - self.model.stiffening_limit).max(0.0))
    }

    /// g′ with what it is off by where y is, whose slope is g″.
    fn slope(&self) -> f64 {
        self.first() + self.second() * self.model.stiffening * self.strain
    }

    /// 2 b g″ likewise; past the limit it is constant, and nearer to it than f32 tells it is either.
    fn growth(&self) -> f64 {
        let (b, limit) = (self.model.stiffening, self.model.stiffening_limit);
        let error = b * self.strain;
        let near = self.y < limit * (1.0 + 1e-3);
        2.0 * b * self.second() * (1.0 + if near { error } else { 0.0 })
    }
}

/// The fibres' part.
struct Fibres {
    axes: DMat3,
    /// The matrices of √k_i k_j and √a_i a_j.
    moduli: DMat3,
    rates: DMat3,
    saturation: f64,
    limit: f64,
    /// E and Q, and E with all signs plus.
    exact: DMat3,
    q: f64,
    strain: DMat3,
}

impl Fibres {
    fn new(m: &Orthotropic, tissue: &MaterialPoint<'_>, h: DMat3, abs_h: DMat3) -> Self {
        let axes = DMat3::from_quat(tissue.local.axes);
        let roots = |d: [f64; 3]| {
            let r = DVec3::from_array(d.map(f64::sqrt));
            DMat3::from_cols(r * r.x, r * r.y, r * r.z)
        };
        let strain =
            |h: DMat3, g: DMat3| g.transpose() * (h + h.transpose() + h.transpose() * h) * g * 0.5;
        let rates = roots(m.saturation_rates);
        let (exact, strain) = (strain(h, axes), strain(abs_h, abs(axes)));
        Self {
            axes: abs(axes),
            moduli: roots(m.fibre_moduli),
            rates,
            saturation: m.saturation,
            limit: m.saturation_limit,
            exact,
            q: double_dot(exact, by_entries(rates, exact)),
            strain,
        }
    }

    /// The error of Q over that of E: twice |E| : (A ∘ Ē).
    fn q_error(&self) -> f64 {
        2.0 * double_dot(abs(self.exact), by_entries(self.rates, self.strain))
    }

    /// c e^min(Q, Q_max); below the limit an error of Q is one of the exponential, relative to it.
    fn slope(&self) -> f64 {
        let error = if self.q < self.limit {
            self.q_error()
        } else {
            0.0
        };
        self.saturation * self.q.min(self.limit).exp() * (1.0 + error)
    }

    /// W.
    fn weights(&self) -> DMat3 {
        self.moduli + self.rates * self.slope()
    }
}

impl<'a> Magnitudes<'a> {
    /// At `tissue` with H = `h`, whose terms sum to `abs_h` in absolute value.
    pub fn new(tissue: MaterialPoint<'a>, h: DMat3, abs_h: DMat3) -> Self {
        let (mu, lambda) = match tissue.material {
            Material::StableNeoHookean(m) => m.lame(),
            Material::Orthotropic(m) => m.ground().lame(),
            Material::FungNeoHookean(m) => m.lame(),
        };
        let mut out = Self {
            tissue,
            mu,
            lambda,
            f: DMat3::IDENTITY + h,
            h: abs_h,
            fibres: None,
            stiffening: None,
        };
        match tissue.material {
            Material::StableNeoHookean(_) => {}
            Material::Orthotropic(m) => out.fibres = Some(Fibres::new(m, &tissue, h, abs_h)),
            Material::FungNeoHookean(m) => out.stiffening = Some(Stiffening::new(*m, h, abs_h)),
        }
        out
    }

    /// μ, or μ g′.
    fn shear_modulus(&self) -> f64 {
        self.mu * self.stiffening.as_ref().map_or(1.0, Stiffening::slope)
    }

    fn volume(&self) -> f64 {
        let h = self.h;
        abs_trace(h) + abs_trace(abs_cofactor(h)) + abs_determinant(h)
    }

    fn shear(&self) -> DMat3 {
        let h = self.h;
        h + h.transpose() + DMat3::from_diagonal(DVec3::splat(abs_trace(h))) + abs_cofactor(h)
    }

    /// P. A polynomial in H of degree 5, H a sum of `handles` products: at most n_h + 3 roundings in each of five factors,
    /// twenty between them, and five of the stiffness, its factor and tension. The fibres' exponent is of degree 4 (its error is in [`Fibres::slope`]) and turned in and
    /// out of axes that are rounded themselves: sixty more with the exponential's own, 3 + 2 Q_max, and a quotient.
    pub fn stress(&self, handles: usize) -> (DMat3, usize) {
        let f = DMat3::IDENTITY + self.h;
        let mu = self.shear_modulus();
        let kappa = self.lambda + mu;
        let mut out = mu * self.shear() + kappa * self.volume() * abs_cofactor(f);
        let mut roundings = 5 * (handles + 3) + 25;
        if let Some(fibres) = &self.fibres {
            let s = by_entries(fibres.weights(), fibres.strain);
            out += f * (fibres.axes * s * fibres.axes.transpose());
            roundings += 60;
        }
        if self.stiffening.is_some() {
            roundings += Stiffening::ROUNDINGS;
        }
        (out * self.tissue.local.stiffness, roundings)
    }

    /// C. It is Lipschitz in H (the projection onto a convex cone does not expand), so that its error is that of the
    /// unprojected C, whose terms cancel, and that of the modes taken out of it, none of which is larger than C itself. Into these
    /// the Jacobi sweeps enter twice: five sweeps of three [`ROTATION`]s, or for a 9×9 matrix seven sweeps, in each of which sixteen
    /// rotations touch an entry. Nine modes are added.
    pub fn tangent(&self, handles: usize) -> (f64, usize) {
        let f = DMat3::IDENTITY + self.h;
        let mu = self.shear_modulus();
        let kappa = self.lambda + mu;
        let pressure = kappa * self.volume() + mu;
        let mut out = mu + kappa * size(abs_cofactor(f)).powi(2) + pressure * size(f);
        let mut roundings = 4 * (handles + 3) + 25;
        let mut of_modes = 4 * 15 * ROTATION + 9 * 3;
        if let Some(fibres) = &self.fibres {
            let stress = by_entries(fibres.weights(), fibres.strain);
            let t = f * fibres.axes * by_entries(fibres.rates, fibres.strain);
            out += 3f64.sqrt() * size(stress)
                + size(fibres.weights()) * size(f).powi(2)
                + 2.0 * fibres.slope() * size(t).powi(2);
            roundings += 60;
            of_modes += 2 * 7 * 16 * ROTATION;
        }
        if let Some(stiffening) = &self.stiffening {
            let a = self.shear() + self.volume() * abs_cofactor(f);
            out += self.mu * stiffening.growth() * size(a).powi(2);
            roundings += Stiffening::ROUNDINGS;
        }
        let exact = self.tissue.tangent(self.f);
        let exact: f64 = exact.iter().flatten().map(|c| c * c).sum();
        let modes = exact.sqrt() * of_modes as f64 / roundings as f64;
        (out * self.tissue.local.stiffness + modes, roundings)
    }

    /// Whether Q is so near to its limit that f32 may see it on the other side, where C is another.
    pub fn is_at_the_clamp(&self) -> bool {
        let near = |f: &Fibres| (f.q - f.limit).abs() < 1e-4 * f.q_error();
        self.fibres.as_ref().is_some_and(near)
    }

    /// Whether Q, or b Q, is past its limit.
    pub fn is_clamped(&self) -> bool {
        let stiffest = |s: &Stiffening| s.y > s.model.stiffening_limit;
        (self.fibres.as_ref()).is_some_and(|f| f.q > f.limit)
            || self.stiffening.as_ref().is_some_and(stiffest)
    }

    /// Ψ(F + D) − Ψ(F), D exactly `d` and in absolute values `abs_d`; see the kernels for the formulas.
    pub fn energy_difference(&self, h: DMat3, d: DMat3, abs_d: DMat3) -> f64 {
        let f = DMat3::IDENTITY + self.h;
        let higher = double_dot(f, abs_cofactor(abs_d)) + abs_determinant(abs_d);
        let volume_difference = double_dot(abs_cofactor(f), abs_d) + higher;
        let shear = double_dot(self.shear(), abs_d) + 0.5 * double_dot(abs_d, abs_d) + higher;
        let square = volume_difference * (2.0 * self.volume() + volume_difference);
        if let Some(stiffening) = &self.stiffening {
            // ΔQ times the mean of g′, which the larger of its ends bounds; y moves both ends.
            let last = Stiffening::new(stiffening.model, h + d, self.h + abs_d);
            let (a, b) = (stiffening.first(), last.first());
            let difference = a.max(b) * (2.0 * shear + square) + (b - a).abs() * stiffening.strain;
            let out = 0.5 * (self.mu * difference + self.lambda * square);
            return out * self.tissue.local.stiffness;
        }
        let mut out = self.mu * shear + 0.5 * (self.lambda + self.mu) * square;
        if let Some(fibres) = &self.fibres {
            let fd = f.transpose() * abs_d;
            let change = fibres.axes.transpose()
                * (fd + fd.transpose() + abs_d.transpose() * abs_d)
                * fibres.axes
                * 0.5;
            let between = fibres.strain * 2.0 + change;
            let last = match self.tissue.material {
                Material::Orthotropic(m) => Fibres::new(m, &self.tissue, h + d, self.h + abs_d),
                Material::StableNeoHookean(_) | Material::FungNeoHookean(_) => return f64::NAN,
            };
            // ΔE : (M ∘ (2 E + ΔE)) errs in either factor; and eˣ − 1 ≤ x e^max(x, 0).
            let exact_change = abs(last.exact - fibres.exact);
            let exact_between = abs(last.exact + fibres.exact);
            let form = |m: DMat3| {
                double_dot(change, by_entries(m, exact_between))
                    + double_dot(exact_change, by_entries(m, between))
            };
            let slope = fibres.slope().max(last.slope());
            out += 0.5 * (form(fibres.moduli) + slope * form(fibres.rates));
        }
        out * self.tissue.local.stiffness
    }

    /// Roundings of an energy: degree ≤ 6, and what the fibres add.
    pub fn energy_roundings(&self, handles: usize) -> usize {
        let of_stiffening =
            (self.stiffening.as_ref()).map_or(0, |_| Stiffening::DIFFERENCE_ROUNDINGS);
        5 * (handles + 3) + 30 + if self.fibres.is_some() { 60 } else { 0 } + of_stiffening
    }
}
