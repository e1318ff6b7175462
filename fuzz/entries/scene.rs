// SPDX-License-Identifier: MIT OR Apache-2.0
//! Numbers, laws, bodies and steps out of bytes; and what must hold of every call.

use std::ffi::{CStr, CString};
use std::mem::MaybeUninit;
use std::ptr;
use std::sync::{Mutex, PoisonError};

use arbitrary::{Result, Unstructured};
use ellgran::c_api::contact::EllgranBody;
use ellgran::c_api::law::*;
use ellgran::c_api::particles::*;
use ellgran::c_api::status::*;
use ellgran::simd::InstructionSet;

/// Bytes that are read as a scene; when they end, zeros follow.
pub type Bytes<'a> = Unstructured<'a>;

/// Numbers at which something may change.
const SPECIAL: [f64; 24] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    0.5,
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    f64::MIN_POSITIVE,
    5e-324,
    f64::MAX,
    f64::MIN,
    f64::EPSILON,
    1.0 + f64::EPSILON,
    1e-20,
    1e20,
    1e-50,
    1e50,
    1e15,
    -1e20,
    1e25,
    1e-160,
    1e160,
    2.0,
];

/// Any number, most of them of the order of 1.
pub fn number(u: &mut Bytes) -> Result<f64> {
    Ok(match u.arbitrary::<u8>()? {
        k @ 0..=39 => SPECIAL[usize::from(k) % SPECIAL.len()],
        40..=63 => f64::from_bits(u.arbitrary()?),
        64..=95 => 10.0_f64.powf(f64::from(u.arbitrary::<i8>()?) / 4.0),
        _ => usual(u)?,
    })
}

/// From -2 to 2.
pub fn usual(u: &mut Bytes) -> Result<f64> {
    Ok(f64::from(u.arbitrary::<i16>()?) / 16384.0)
}

pub fn usual_vector<const N: usize>(u: &mut Bytes) -> Result<[f64; N]> {
    let mut vector = [0.0; N];
    for x in &mut vector {
        *x = usual(u)?;
    }
    Ok(vector)
}

/// One time in `out_of`.
pub fn one_in(u: &mut Bytes, out_of: u8) -> Result<bool> {
    Ok(u.arbitrary::<u8>()? % out_of == out_of - 1)
}

/// Words of a law.
fn deck(u: &mut Bytes) -> Result<String> {
    fn constant(u: &mut Bytes, order: i32, text: &mut String) -> Result<()> {
        let value = if one_in(u, 16)? {
            number(u)?
        } else {
            10.0_f64.powi(order) * (0.1 + usual(u)?.abs())
        };
        *text += &format!(" {value:e}");
        Ok(())
    }
    fn material(u: &mut Bytes, text: &mut String) -> Result<()> {
        let order = u.int_in_range(0..=9)?;
        constant(u, order, text)?;
        if one_in(u, 8)? {
            constant(u, 0, text)
        } else {
            *text += ["0.3", " 0", " 0.5", " -0.4"][u.int_in_range(0..=3)?];
            Ok(())
        }
    }
    let mut text = String::new();
    match u.int_in_range(0..=2)? {
        0 => {
            text += "hertz";
            material(u, &mut text)?;
        }
        1 => {
            text += "nfd";
            material(u, &mut text)?;
            for _ in 0..2 {
                let order = u.int_in_range(-3..=6)?;
                constant(u, order, &mut text)?;
            }
        }
        _ => {
            text += "lsd";
            for _ in 0..2 {
                let order = u.int_in_range(-3..=6)?;
                constant(u, order, &mut text)?;
            }
        }
    }
    let of = |u: &mut Bytes, words: &[&str], text: &mut String| -> Result<()> {
        if u.arbitrary()? {
            *text += u.choose(words)?;
        }
        Ok(())
    };
    match u.int_in_range(0..=5)? {
        0 => {
            text += " damping restitution";
            constant(u, -1, &mut text)?;
        }
        1 => {
            text += " damping relaxation";
            let order = u.int_in_range(-6..=1)?;
            constant(u, order, &mut text)?;
        }
        _ => {}
    }
    match u.int_in_range(0..=4)? {
        0 => {}
        1 => {
            text += " tangential linear";
            for _ in 0..3 {
                let order = u.int_in_range(-2..=4)?;
                constant(u, order, &mut text)?;
            }
        }
        word => {
            text += if word == 2 {
                " tangential mindlin"
            } else {
                " tangential tfd"
            };
            let order = u.int_in_range(-1..=2)?;
            constant(u, order, &mut text)?;
        }
    }
    let displacements = [
        " displacement total",
        " displacement incremental",
        " displacement rescaled",
    ];
    of(u, &displacements, &mut text)?;
    of(
        u,
        &[
            " closure energy",
            " closure surface",
            " closure brilliantov",
        ],
        &mut text,
    )?;
    of(u, &[" unloading ting", " unloading first_order"], &mut text)?;
    of(u, &[" factors exact", " factors hale"], &mut text)?;
    of(u, &[" conservative yes", " conservative no"], &mut text)?;
    of(u, &[" limit_force yes", " limit_force no"], &mut text)?;
    if one_in(u, 4)? {
        text += " rolling sds";
        for order in [3, 0, -1] {
            constant(u, order, &mut text)?;
        }
    }
    match u.int_in_range(0..=7)? {
        0 => text += " twisting marshall",
        1 => {
            text += " twisting sds";
            for order in [3, 0, -1] {
                constant(u, order, &mut text)?;
            }
        }
        _ => {}
    }
    Ok(text)
}

/// Laws of one or two types.
pub struct Laws {
    pub pointer: *mut EllgranLaws,
    /// The parameters of each type with itself.
    pub given: Vec<EllgranLawParameters>,
    pub types: i32,
    pub length: usize,
}

impl Laws {
    /// None where the words are refused.
    pub fn read(u: &mut Bytes) -> Result<Option<Laws>> {
        let types = u.int_in_range(1..=2)?;
        let mut parameters = Vec::new();
        for _ in 0..types * types {
            let text = deck(u)?;
            show("law", &text);
            let words: Vec<CString> = text
                .split_whitespace()
                .map(|word| CString::new(word).expect("no NUL"))
                .collect();
            let words: Vec<_> = words.iter().map(|word| word.as_ptr()).collect();
            let mut read = sized::<EllgranLawParameters>();
            // SAFETY: the strings live to the end of the call; the output is valid for writes.
            let status = unsafe {
                ellgran_law_parameters_parse(
                    words.len(),
                    words.as_ptr(),
                    ptr::null_mut(),
                    &mut read,
                )
            };
            if !succeeded(status) {
                return Ok(None);
            }
            parameters.push(read);
        }
        // The pair of two types is set by itself, or mixed.
        let mixed = types == 2 && u.arbitrary()?;
        let is_set: Vec<u8> = (0..types * types)
            .map(|k| u8::from(k % (types + 1) == 0 || (k == 1 && !mixed)))
            .collect();
        let options = u.int_in_range(0..=1)?;
        let mut pointer = ptr::null_mut();
        // SAFETY: the arrays have an entry for each pair of types.
        let status = unsafe {
            ellgran_laws_new(
                types as i32,
                parameters.as_ptr(),
                is_set.as_ptr(),
                options,
                &mut pointer,
            )
        };
        if !succeeded(status) {
            return Ok(None);
        }
        // SAFETY: valid since it was made.
        let length = unsafe { ellgran_laws_history_length(pointer) } as usize;
        Ok(Some(Laws {
            pointer,
            given: parameters.into_iter().step_by(types + 1).collect(),
            types: types as i32,
            length,
        }))
    }
}

impl Drop for Laws {
    fn drop(&mut self) {
        // SAFETY: made by ellgran_laws_new and not used again.
        unsafe { ellgran_laws_free(self.pointer) }
    }
}

/// A struct of zeros with its size.
pub fn sized<T>() -> T {
    let mut value = MaybeUninit::<T>::zeroed();
    // SAFETY: structs of the interface begin with their size, and zeros are a value of every other field.
    unsafe {
        value.as_mut_ptr().cast::<usize>().write(size_of::<T>());
        value.assume_init()
    }
}

/// A workspace of an instruction set that this machine has.
pub struct Workspace(pub *mut EllgranWorkspace);

impl Workspace {
    pub fn read(u: &mut Bytes) -> Result<Workspace> {
        static ENVIRONMENT: Mutex<()> = Mutex::new(());
        let sets: Vec<_> = InstructionSet::ALL
            .into_iter()
            .filter(|set| set.is_available())
            .collect();
        let set = u.choose(&sets)?;
        show("instruction set", set);
        let _alone = ENVIRONMENT.lock().unwrap_or_else(PoisonError::into_inner);
        std::env::set_var("ELLGRAN_INSTRUCTION_SET", set.name());
        let mut pointer = ptr::null_mut();
        // SAFETY: valid for writes.
        let status = unsafe { ellgran_workspace_new(&mut pointer) };
        assert!(succeeded(status));
        Ok(Workspace(pointer))
    }
}

impl Drop for Workspace {
    fn drop(&mut self) {
        // SAFETY: made by ellgran_workspace_new and not used again.
        unsafe { ellgran_workspace_free(self.0) }
    }
}

/// A body near the origin, one time in four with a number that is any.
pub fn body(u: &mut Bytes, types: i32) -> Result<EllgranBody> {
    let slender = one_in(u, 4)?;
    let mut semi_axes = usual_vector(u)?.map(|x: f64| 0.5 + 0.45 * x.abs());
    if slender {
        semi_axes[u.int_in_range(0..=2)?] *= 10.0_f64.powi(u.int_in_range(-6..=6)?);
    }
    if one_in(u, 8)? {
        semi_axes = [semi_axes[0]; 3];
    }
    let mut body = EllgranBody {
        size: size_of::<EllgranBody>(),
        position: usual_vector(u)?,
        quaternion: usual_vector(u)?,
        semi_axes,
        velocity: usual_vector(u)?,
        angular_velocity: usual_vector(u)?,
        mass: 0.1 + usual(u)?.abs(),
        particle_type: u.int_in_range(1..=types)?,
        identifier: u.arbitrary()?,
        velocity_change: [0.0; 3],
        angular_velocity_change: [0.0; 3],
        velocities_of_step: 0,
    };
    if one_in(u, 4)? {
        body.velocities_of_step = 1;
        body.velocity_change = usual_vector(u)?;
        body.angular_velocity_change = usual_vector(u)?;
    }
    if one_in(u, 4)? {
        let value = number(u)?;
        let k = u.int_in_range(0..=2)?;
        match u.int_in_range(0..=8)? {
            0 => body.position[k] = value,
            1 => body.quaternion[k] = value,
            2 => body.semi_axes[k] = value,
            3 => body.velocity[k] = value,
            4 => body.angular_velocity[k] = value,
            5 => body.mass = value,
            6 => body.velocity_change[k] = value,
            7 => body.angular_velocity_change[k] = value,
            _ => body.particle_type = u.arbitrary()?,
        }
    }
    show("body", &body);
    Ok(body)
}

pub fn step(u: &mut Bytes) -> Result<EllgranStep> {
    let step = EllgranStep {
        size: size_of::<EllgranStep>(),
        time_step: if one_in(u, 16)? {
            number(u)?
        } else {
            10.0_f64.powi(u.int_in_range(-6..=0)?)
        },
        advance_history: i32::from(!one_in(u, 4)?),
    };
    show("step", &step);
    Ok(step)
}

/// Moves a body as its velocities say.
pub fn advance(body: &mut EllgranBody, time: f64) {
    for (x, v) in body.position.iter_mut().zip(body.velocity) {
        *x += time * v;
    }
}

/// Whether a call succeeded. One that failed has a status of the header and says why.
#[track_caller]
pub fn succeeded(status: i32) -> bool {
    if status == ELLGRAN_SUCCESS {
        return true;
    }
    // SAFETY: never NULL and ends with NUL.
    let message = unsafe { CStr::from_ptr(ellgran_last_error()) };
    let message = message.to_str().expect("UTF-8");
    show("refused", &message);
    assert!(message.len() > 10, "status {status}: {message}");
    assert!(
        [
            ELLGRAN_ERROR_ARGUMENT,
            ELLGRAN_ERROR_TEXT,
            ELLGRAN_ERROR_LAW,
            ELLGRAN_ERROR_HALE,
            ELLGRAN_ERROR_PARTICLE,
            ELLGRAN_ERROR_HISTORY,
            ELLGRAN_ERROR_RESULT,
        ]
        .contains(&status),
        "status {status}: {message}"
    );
    false
}

/// Says what was read, if the environment variable `ELLGRAN_FUZZ_SHOW` is set: what an input is that failed.
pub fn show(what: &str, value: &dyn std::fmt::Debug) {
    if std::env::var_os("ELLGRAN_FUZZ_SHOW").is_some() {
        eprintln!("{what} = {value:?}");
    }
}

#[track_caller]
pub fn assert_finite(what: &str, values: &[f64]) {
    assert!(values.iter().all(|x| x.is_finite()), "{what}: {values:?}");
}

/// The same bits, NaN among them.
pub fn same_bits(a: &[f64], b: &[f64]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(x, y)| x.to_bits() == y.to_bits())
}
