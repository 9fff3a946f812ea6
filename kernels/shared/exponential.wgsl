// (eˣ − 1)/x, the mean of the exponential from 0 to x: by its series where the difference would cancel.
fn mean_exponential(x: f32) -> f32 {
    if (abs(x) > 0.5) {
        return (exp(x) - 1.0) / x;
    }
    return 1.0 + x / 2.0 * (1.0 + x / 3.0 * (1.0 + x / 4.0 * (1.0 + x / 5.0
        * (1.0 + x / 6.0 * (1.0 + x / 7.0 * (1.0 + x / 8.0))))));
}
