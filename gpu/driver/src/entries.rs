// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which kernel serves which shapes and laws.

use crate::device::{Device, Kernels, OnDevice};
use crate::driver_library::{Function, Stream};
use crate::status::ELLGRAN_GPU_ERROR_LAWS;
use core::marker::PhantomData;
use ellgran::c_api::status::Failure;
use ellgran::contact::history::Remembers;
use ellgran::contact::{HistoryLayout, Laws};
use ellgran_kernels::arguments::{
    CandidateArguments, CarryPairsArguments, CarryWallArguments, ContactArguments, FileArguments,
    MeshArguments, MotionArguments, NumberArguments, PlaneArguments, PoseArguments,
    PrepareArguments, ShapeArguments, SumArguments, TallyArguments, TermArguments, WallArguments,
};

/// Threads of a block: the contact kernels take 255 registers of 65536 a thread, so two such blocks fit.
const BLOCK: u32 = 128;
/// The same of kernels whose threads are few, each with much to do: they are spread over the processors.
const SMALL_BLOCK: u32 = 32;

/// The kind of shape that a scene is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shapes {
    /// Spheres alone.
    Spheres,
    /// Spheroids, and spheres among them.
    Spheroids,
    /// Any ellipsoids.
    Ellipsoids,
}

impl Shapes {
    fn word(self) -> &'static str {
        match self {
            Shapes::Spheres => "spheres",
            Shapes::Spheroids => "spheroids",
            Shapes::Ellipsoids => "ellipsoids",
        }
    }
}

/// The precision of contacts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Precision {
    /// All in double precision.
    #[default]
    Double,
    /// Their search in single precision (`ellgran_kernels::mixed`).
    Mixed,
}

/// What the laws of a scene have, as far as kernels and histories differ by it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Terms {
    /// A history begins with a normal.
    pub cached_normal: bool,
    /// A history has a tangential part.
    pub tangential: bool,
    /// And the energy of it.
    pub rescaled: bool,
    /// Conservative terms.
    pub conservative: bool,
    /// A term that reads masses.
    pub mass: bool,
}

impl Terms {
    /// Of laws.
    ///
    /// # Errors
    /// Laws without a kernel.
    pub fn of(laws: &Laws) -> Result<Terms, Failure> {
        let fail = |what: &str| {
            Err(Failure::new(
                ELLGRAN_GPU_ERROR_LAWS,
                format!(
                    "{what} on a GPU: use other laws, or the functions of ellgran.h on the host"
                ),
            ))
        };
        let (features, layout) = (laws.features(), laws.layout());
        if features.resistance || layout.rolling.is_some() || layout.twisting.is_some() {
            return fail("no kernel resists rolling or twisting");
        }
        if layout.springs.is_some() {
            return fail("no kernel has `displacement hysteretic`");
        }
        if features.memory || layout.rests.is_some() {
            return fail("no kernel has `viscosity memory`");
        }
        if features.hale {
            return fail("no kernel has `factors hale`");
        }
        let terms = Terms {
            cached_normal: layout.normal.is_some(),
            tangential: layout.memory.is_some(),
            rescaled: layout.energy.is_some(),
            conservative: features.conservative,
            mass: features.mass,
        };
        // What a kernel makes of it.
        let made = HistoryLayout::new(Remembers {
            normal: terms.cached_normal,
            tangential: terms.tangential,
            energy: terms.rescaled,
            ..Remembers::default()
        });
        if made.length != layout.length {
            return fail("no kernel has histories of these laws");
        }
        Ok(terms)
    }
}

/// A kernel, with the type of what it is called with.
pub struct Entry<A> {
    name: String,
    function: Function,
    of: PhantomData<fn(A)>,
}

impl<A> Entry<A> {
    fn new(device: &Device, name: String) -> Result<Self, Failure> {
        Entry::of(device, Kernels::Grains, name)
    }

    fn of(device: &Device, kernels: Kernels, name: String) -> Result<Self, Failure> {
        Ok(Entry {
            function: device.function(kernels, &name)?,
            name,
            of: PhantomData,
        })
    }

    /// Starts it with `count` threads.
    ///
    /// # Errors
    /// Of the driver.
    pub fn launch(
        &self,
        device: &Device,
        stream: Stream,
        count: usize,
        arguments: &A,
    ) -> Result<(), Failure> {
        self.launch_blocks(device, stream, (count, BLOCK), arguments)
    }

    /// The same in small blocks.
    ///
    /// # Errors
    /// Of the driver.
    pub fn launch_spread(
        &self,
        device: &Device,
        stream: Stream,
        count: usize,
        arguments: &A,
    ) -> Result<(), Failure> {
        self.launch_blocks(device, stream, (count, SMALL_BLOCK), arguments)
    }

    fn launch_blocks(
        &self,
        device: &Device,
        stream: Stream,
        (count, block): (usize, u32),
        arguments: &A,
    ) -> Result<(), Failure> {
        // Scenes have been checked for it.
        let count = count as u32;
        device
            .driver()
            .launch(self.function, &self.name, count, block, arguments, stream)
    }
}

/// The kernels that serve any scene.
pub struct Common {
    /// See [`crate::scene`].
    pub start_step: Entry<MotionArguments<OnDevice>>,
    /// The second half of a step.
    pub finish_step: Entry<MotionArguments<OnDevice>>,
    /// Where grains were when candidates were selected.
    pub remember_poses: Entry<PoseArguments<OnDevice>>,
    /// Numbers of the candidates.
    pub number_candidates: Entry<NumberArguments<OnDevice>>,
    /// Which contacts add to the load of each grain.
    pub terms: Entry<TermArguments<OnDevice>>,
    /// The loads of each grain.
    pub sum_contacts: Entry<SumArguments<OnDevice>>,
    /// What shapes are not.
    pub find_shapes: Entry<ShapeArguments<OnDevice>>,
    /// Where grains were in a list.
    pub file_identifiers: Entry<FileArguments<OnDevice>>,
    /// Histories of pairs.
    pub carry_pairs: Entry<CarryPairsArguments<OnDevice>>,
    /// Histories of walls.
    pub carry_wall: Entry<CarryWallArguments<OnDevice>>,
}

impl Common {
    /// Of a device.
    ///
    /// # Errors
    /// Of the driver.
    pub fn new(device: &Device) -> Result<Self, Failure> {
        let name = |name: &str| format!("ellgran_{name}");
        Ok(Common {
            start_step: Entry::new(device, name("start_step"))?,
            finish_step: Entry::new(device, name("finish_step"))?,
            remember_poses: Entry::new(device, name("remember_poses"))?,
            number_candidates: Entry::new(device, name("number_candidates"))?,
            terms: Entry::new(device, name("terms"))?,
            sum_contacts: Entry::new(device, name("sum_contacts"))?,
            find_shapes: Entry::new(device, name("find_shapes"))?,
            file_identifiers: Entry::new(device, name("file_identifiers"))?,
            carry_pairs: Entry::new(device, name("carry_pairs"))?,
            carry_wall: Entry::new(device, name("carry_wall"))?,
        })
    }
}

/// The kernels that serve some shapes and some laws.
pub struct Chosen {
    /// For these shapes.
    pub shapes: Shapes,
    /// Preparation.
    pub prepare: Entry<PrepareArguments<OnDevice>>,
    /// Candidates.
    pub candidates: Entry<CandidateArguments<OnDevice>>,
    /// Contacts.
    pub contacts: Entry<ContactArguments<OnDevice>>,
    /// Those that the first has marked.
    pub marked_contacts: Entry<ContactArguments<OnDevice>>,
    /// Planes.
    pub plane: Entry<PlaneArguments<OnDevice>>,
}

/// The kernel of walls of cylinders and the like.
pub struct WallEntry(pub Entry<WallArguments<OnDevice>>);

impl WallEntry {
    /// Has it assembled where it is not.
    ///
    /// # Errors
    /// Of the driver.
    pub fn new(device: &Device) -> Result<Self, Failure> {
        Entry::of(device, Kernels::Walls, NAME_OF_WALLS.to_owned()).map(WallEntry)
    }
}

const NAME_OF_WALLS: &str = "ellgran_wall";

/// Kernels of walls with triangles.
pub struct MeshEntries {
    /// Which grains are near, where they are spheres or spheroids, and where they are ellipsoids.
    near: [Entry<MeshArguments<OnDevice>>; 2],
    /// Their contacts.
    pub contacts: Entry<MeshArguments<OnDevice>>,
}

impl MeshEntries {
    /// Has them assembled where they are not.
    ///
    /// # Errors
    /// Of the driver.
    pub fn new(device: &Device) -> Result<Self, Failure> {
        let [spheroids, ellipsoids, contacts] =
            NAMES_OF_MESHES.map(|name| Entry::of(device, Kernels::Meshes, name.to_owned()));
        Ok(MeshEntries {
            near: [spheroids?, ellipsoids?],
            contacts: contacts?,
        })
    }

    /// Which grains are near.
    pub fn near(&self, shapes: Shapes) -> &Entry<MeshArguments<OnDevice>> {
        &self.near[usize::from(shapes == Shapes::Ellipsoids)]
    }
}

/// Those of energies and virial.
pub struct TallyEntries([Entry<TallyArguments<OnDevice>>; 2]);

impl TallyEntries {
    /// Has them assembled where they are not.
    ///
    /// # Errors
    /// Of the driver.
    pub fn new(device: &Device) -> Result<Self, Failure> {
        let [spheroids, ellipsoids] =
            NAMES_OF_TALLIES.map(|name| Entry::of(device, Kernels::Tallies, name.to_owned()));
        Ok(TallyEntries([spheroids?, ellipsoids?]))
    }

    /// Of such grains.
    pub fn of(&self, shapes: Shapes) -> &Entry<TallyArguments<OnDevice>> {
        &self.0[usize::from(shapes == Shapes::Ellipsoids)]
    }
}

/// Names of the kernels of energies and virial: of spheres and spheroids, and of ellipsoids.
const NAMES_OF_TALLIES: [&str; 2] = ["ellgran_tally_spheroids", "ellgran_tally_ellipsoids"];

/// Names of the kernels of walls with triangles: which spheroids, and which ellipsoids, are near, and contacts.
const NAMES_OF_MESHES: [&str; 3] = [
    "ellgran_near_mesh_spheroids",
    "ellgran_near_mesh_ellipsoids",
    "ellgran_mesh",
];

/// Names of the kernels: preparation, candidates, contacts, marked contacts, planes.
fn names(shapes: Shapes, terms: Terms, precision: Precision) -> [String; 5] {
    let kind = shapes.word();
    // Marked contacts and planes take spheres as spheroids.
    let spheroids_too = match shapes {
        Shapes::Spheres => Shapes::Spheroids.word(),
        _ => kind,
    };
    let terms_of_contacts = match (shapes, terms.tangential, terms.conservative) {
        // On spheres the conservative terms vanish.
        (Shapes::Spheres, false, _) => "",
        (Shapes::Spheres, true, _) | (_, true, false) => "_friction",
        (_, true, true) => "_friction_conservative",
        (_, false, _) => "_conservative",
    };
    let mixed = match (shapes, precision) {
        // Two spheres have no search.
        (Shapes::Spheres, _) | (_, Precision::Double) => "",
        (_, Precision::Mixed) => "mixed_",
    };
    let terms_of_planes = if terms.tangential {
        "_friction_conservative"
    } else {
        "_conservative"
    };
    [
        format!("ellgran_prepare_{kind}"),
        format!("ellgran_candidates_{kind}"),
        format!("ellgran_contacts_{mixed}{kind}{terms_of_contacts}"),
        format!("ellgran_marked_contacts_{spheroids_too}"),
        format!("ellgran_plane_{spheroids_too}{terms_of_planes}"),
    ]
}

impl Chosen {
    /// Of a device.
    ///
    /// # Errors
    /// Of the driver.
    pub fn new(
        device: &Device,
        shapes: Shapes,
        terms: Terms,
        precision: Precision,
    ) -> Result<Self, Failure> {
        let [prepare, candidates, contacts, marked_contacts, plane] =
            names(shapes, terms, precision);
        Ok(Chosen {
            shapes,
            prepare: Entry::new(device, prepare)?,
            candidates: Entry::new(device, candidates)?,
            contacts: Entry::new(device, contacts)?,
            marked_contacts: Entry::new(device, marked_contacts)?,
            plane: Entry::new(device, plane)?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn laws(words: &str) -> Laws {
        let words: Vec<&str> = words.split(' ').collect();
        let (parameters, _) = ellgran::force::syntax::parse(&words).unwrap();
        Laws::new(1, &[Some(parameters)], true).unwrap()
    }

    #[test]
    fn laws_without_a_kernel_are_refused() {
        for (words, what) in [
            ("hertz 1e7 0.3 factors hale conservative no", "hale"),
            (
                "hertz 1e7 0.3 tangential mindlin 0.5 rolling sds 1e3 1 0.1",
                "rolling",
            ),
            (
                "hertz 1e7 0.3 tangential mindlin 0.5 twisting marshall",
                "twisting",
            ),
        ] {
            let failure = Terms::of(&laws(words)).unwrap_err();
            assert_eq!(failure.status, ELLGRAN_GPU_ERROR_LAWS);
            assert!(failure.message.contains(what), "{}", failure.message);
        }
    }

    /// A friction of 0 leaves the histories as long as they were.
    #[test]
    fn a_kernel_has_the_histories_of_its_laws() {
        let without = laws("hertz 1e7 0.3 tangential mindlin 0.5")
            .with_friction(&[0.0])
            .unwrap();
        let terms = Terms::of(&without).unwrap();
        assert!(terms.tangential && terms.rescaled);
    }

    /// What the text of a module says of the second parameter of a kernel: size and alignment.
    fn parameter(kernels: Kernels, name: &str) -> (usize, usize) {
        let (_, rest) = kernels
            .text()
            .split_once(&format!(".entry {name}("))
            .expect(name);
        let (list, _) = rest.split_once(')').expect(name);
        let second = list.split(',').nth(1).expect(name);
        let words: Vec<&str> = second.split_whitespace().collect();
        let [".param", ".align", alignment, ".b8", spelled] = words[..] else {
            panic!("{name}: {second}");
        };
        let (_, size) = spelled.trim_end_matches(']').split_once('[').expect(name);
        (size.parse().expect(name), alignment.parse().expect(name))
    }

    fn is_of<A>(name: &str) {
        is_there_of::<A>(Kernels::Grains, name);
    }

    fn is_there_of<A>(kernels: Kernels, name: &str) {
        let here = (size_of::<A>(), align_of::<A>());
        assert_eq!(parameter(kernels, name), here, "{name}");
    }

    /// As the compiler for the device has laid them out.
    #[test]
    fn arguments_are_as_long_as_the_kernels_take_them_to_be() {
        is_of::<MotionArguments<OnDevice>>("ellgran_start_step");
        is_of::<MotionArguments<OnDevice>>("ellgran_finish_step");
        is_of::<PoseArguments<OnDevice>>("ellgran_remember_poses");
        is_of::<NumberArguments<OnDevice>>("ellgran_number_candidates");
        is_of::<TermArguments<OnDevice>>("ellgran_terms");
        is_of::<SumArguments<OnDevice>>("ellgran_sum_contacts");
        is_of::<ShapeArguments<OnDevice>>("ellgran_find_shapes");
        is_of::<FileArguments<OnDevice>>("ellgran_file_identifiers");
        is_of::<CarryPairsArguments<OnDevice>>("ellgran_carry_pairs");
        is_of::<CarryWallArguments<OnDevice>>("ellgran_carry_wall");
        is_there_of::<WallArguments<OnDevice>>(Kernels::Walls, NAME_OF_WALLS);
        for name in NAMES_OF_MESHES {
            is_there_of::<MeshArguments<OnDevice>>(Kernels::Meshes, name);
        }
        for name in NAMES_OF_TALLIES {
            is_there_of::<TallyArguments<OnDevice>>(Kernels::Tallies, name);
        }
        for shapes in [Shapes::Spheres, Shapes::Spheroids, Shapes::Ellipsoids] {
            for bits in 0..4 {
                let terms = Terms {
                    cached_normal: true,
                    tangential: bits & 1 != 0,
                    rescaled: false,
                    conservative: bits & 2 != 0,
                    mass: false,
                };
                for precision in [Precision::Double, Precision::Mixed] {
                    let [prepare, candidates, contacts, marked, plane] =
                        names(shapes, terms, precision);
                    is_of::<PrepareArguments<OnDevice>>(&prepare);
                    is_of::<CandidateArguments<OnDevice>>(&candidates);
                    is_of::<ContactArguments<OnDevice>>(&contacts);
                    is_of::<ContactArguments<OnDevice>>(&marked);
                    is_of::<PlaneArguments<OnDevice>>(&plane);
                }
            }
        }
    }
}
