// SPDX-License-Identifier: MIT OR Apache-2.0
//! Ordinary differential equations of a contact, integrated far more finely than any engine would.

/// The state is `[delta, delta_dot, ...]`.
pub type State<const N: usize> = [f64; N];

/// Classical Runge-Kutta of fourth order.
pub fn runge_kutta<const N: usize>(
    rate: &impl Fn(&State<N>) -> State<N>,
    y: &State<N>,
    h: f64,
) -> State<N> {
    let along = |k: &State<N>, t: f64| std::array::from_fn(|n| y[n] + t * k[n]);
    let k1 = rate(y);
    let k2 = rate(&along(&k1, 0.5 * h));
    let k3 = rate(&along(&k2, 0.5 * h));
    let k4 = rate(&along(&k3, h));
    std::array::from_fn(|n| y[n] + h / 6.0 * (k1[n] + 2.0 * k2[n] + 2.0 * k3[n] + k4[n]))
}

/// Integrates until `event` falls below zero and returns time and state at its root (by bisection of the last step).
///
/// The force of a contact is not smooth where the contact begins and ends: `steps` in `span` in between, and steps of a
/// hundredth of `delta/delta_dot` towards the ends.
pub fn until<const N: usize>(
    rate: impl Fn(&State<N>) -> State<N>,
    event: impl Fn(f64, &State<N>) -> f64,
    start: State<N>,
    span: f64,
    steps: usize,
) -> (f64, State<N>) {
    let (mut t, mut y) = (0.0, start);
    while t < 20.0 * span {
        let left = 0.01 * y[0] / y[1].abs();
        let h = left.clamp(1e-15 * span, span / steps as f64);
        let next = runge_kutta(&rate, &y, h);
        if t > 0.0 && event(t + h, &next) < 0.0 {
            let (mut low, mut high) = (0.0, h);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if event(t + middle, &runge_kutta(&rate, &y, middle)) < 0.0 {
                    high = middle;
                } else {
                    low = middle;
                }
            }
            return (t + high, runge_kutta(&rate, &y, high));
        }
        t += h;
        y = next;
    }
    panic!("the event did not come in {t}");
}
