// SPDX-License-Identifier: MIT OR Apache-2.0
//! Whether a grain has moved too far for the present candidates.

use ellgran::geometry::small_motion::{
    allowed_turn, allowed_turn_per_margin, allowed_way, way_and_turn,
};

/// The pose of a grain when candidates were selected: centre, quaternion as the engine has it, square of the change of the quaternion
/// that is allowed.
#[inline(always)]
pub fn remembered_pose(x: [f64; 3], q: [f64; 4], semi_axes: [f64; 3], margin: f64) -> [f64; 8] {
    let per_margin = allowed_turn_per_margin(semi_axes, q);
    let turn = allowed_turn(per_margin, margin * margin, &q);
    [x[0], x[1], x[2], q[0], q[1], q[2], q[3], turn]
}

/// Whether a grain has used up its half of the margin since that pose.
#[inline(always)]
pub fn has_moved(pose: &[f64; 8], x: [f64; 3], q: [f64; 4], margin: f64) -> bool {
    let &[px, py, pz, w, i, j, k, _] = pose;
    let (way, turn) = way_and_turn([px, py, pz], x, [w, i, j, k], q);
    // Not a number holds for nothing.
    !(way <= allowed_way(margin) && turn <= pose[7])
}

#[cfg(test)]
mod tests {
    use super::*;

    const AT: [f64; 3] = [1.0, 2.0, 3.0];
    const NEEDLE: [f64; 3] = [1.1, 0.1, 0.1];

    fn turned(angle: f64) -> [f64; 4] {
        [(0.5 * angle).cos(), 0.0, (0.5 * angle).sin(), 0.0]
    }

    #[test]
    fn a_quarter_of_the_margin_is_for_the_way() {
        let pose = remembered_pose(AT, turned(0.0), NEEDLE, 0.4);
        let moved = |way: f64| has_moved(&pose, [1.0 + way, 2.0, 3.0], turned(0.0), 0.4);
        assert!(!moved(0.099) && moved(0.101) && moved(f64::NAN));
    }

    /// The support function changes by at most the angle times the difference of the semi-axes.
    #[test]
    fn a_quarter_of_the_margin_is_for_the_turn() {
        let pose = remembered_pose(AT, turned(0.0), NEEDLE, 0.4);
        let moved = |angle: f64| has_moved(&pose, AT, turned(angle), 0.4);
        assert!(!moved(0.09) && moved(0.101));
        let sphere = remembered_pose(AT, turned(0.0), [1.0; 3], 0.4);
        assert!(!has_moved(&sphere, AT, turned(3.0), 0.4));
    }
}
