// SPDX-License-Identifier: MIT OR Apache-2.0
//! Does the installer do its work once however often it is run, undo it, and refuse what it does not know?

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::Command;

use crate::harness::fresh_directory;

fn install(words: &[&str], tree: &Path) -> (Option<i32>, String) {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("liggghts-patch/install");
    let output = Command::new("sh")
        .arg(script)
        .arg(tree)
        .args(words)
        .output()
        .unwrap();
    let text = String::from_utf8_lossy(&output.stdout).into_owned()
        + &String::from_utf8_lossy(&output.stderr);
    (output.status.code(), text)
}

/// The few files that the installer touches, as far as it looks at them.
fn tree(name: &str, version: &str) -> std::path::PathBuf {
    let tree = fresh_directory(name);
    let src = tree.join("src");
    fs::create_dir_all(src.join("MAKE")).unwrap();
    for (file, text) in [
        ("version_liggghts.txt", version),
        ("version_liggghts_branch.txt", "LIGGGHTS-PUBLIC\n"),
        ("CMakeLists.txt", "PROJECT(X)\n"),
        ("finish.cpp", "if (list->numneigh > 0) {}\n"),
        (
            "utils.h",
            "return static_cast< std::ostringstream & >(a).str();\n",
        ),
        (
            "dump_particle.cpp",
            "    MathExtra::quat_to_mat(quaternion[i], mat);\n",
        ),
        (
            "write_data.cpp",
            "  if (narg < 1) error->all(FLERR,\"Illegal write_data command\");\n",
        ),
        ("atom_vec_superquadric.cpp", "  size_data_atom = 8;\n"),
        (
            "mesh_module_stress_servo.h",
            "  class A\n  {\n  private:\n\n  };\n",
        ),
        (
            "mesh_module_stress_servo.cpp",
            "    getElementProperty<A>(\"v\")->setAll(0.);\n",
        ),
        ("fix_move_mesh.h", "      private:\n"),
        (
            "fix_move_mesh.cpp",
            "    move_->post_create();\n    // do set-up in case velocity is dumped (called via set-up)\n        v->setAll(0.);\n",
        ),
        (
            "modify.cpp",
            "  fix[ifix]->post_create_pre_restart(); \n  fix[ifix]->post_create(); \n  nfix--;\n  compute[ncompute-1]->post_create(); \n  ncompute--;\n",
        ),
        (
            "run.cpp",
            "      output->init();\n        output->init();\n",
        ),
        (
            "domain.cpp",
            "    prd_lamda[0] = prd_lamda[1] = prd_lamda[2] = 0.0;\n",
        ),
        (
            "fix_insert_stream.cpp",
            "                vectorCopy3D(omega_toInsert,omega[i]);\n                vectorZeroize3D(omega[i]);\n            change_ratio = dt_old / dt;\n            a = static_cast<double>(static_cast<int>(change_ratio*(b)));\n",
        ),
        (
            "replicate.cpp",
            "        error->all(FLERR,\"Replicate command before simulation box is defined\");\n    x[l][0] += i*size_x;\n    x[l][1] += j*size_y;\n    x[l][2] += k*size_z;\n",
        ),
        (
            "fix_wall_gran_base.h",
            "    if(wg->heattransfer_flag())\n       wg->addHeatFlux(mesh);\n",
        ),
        ("fix_ave_euler.cpp", "  nevery = exec_every_;\n"),
        (
            "input_mesh_tri.cpp",
            "  verbose_ = verbose;\n  if(nonlammps_file) fclose(nonlammps_file);\n            fclose(nonlammps_file);\n    double **nodeTmp = create<double>(nodeTmp,3,3);\n",
        ),
        (
            "error.cpp",
            "void Error::all(int a)\n{\n  MPI_Abort(world,1);\n}\nvoid Error::one(int a)\n{\n  if (screen) a;\n  MPI_Abort(world,1);\n}\n",
        ),
        ("dump_mesh_vtk.h", "class A;\n"),
        ("dump_mesh_vtk.cpp", "int a;\n"),
        (
            "MAKE/Makefile.auto",
            "TMP := $(shell echo '\\#include <mpi.h>')\nEXTRA_ADDLIBS=\nall:\n",
        ),
    ] {
        fs::write(src.join(file), text).unwrap();
    }
    tree
}

/// Names and bytes of all files, names alone of directories.
fn content(tree: &Path) -> BTreeMap<String, Vec<u8>> {
    ["src", "src/MAKE", "src/ellgran_vtk"]
        .into_iter()
        .filter_map(|directory| fs::read_dir(tree.join(directory)).ok())
        .flatten()
        .map(|entry| entry.unwrap().path())
        .map(|path| {
            let name = path.to_string_lossy().into_owned();
            (name, fs::read(&path).unwrap_or_default())
        })
        .collect()
}

/// Installs twice and removes: what the user had comes back to the byte.
fn comes_back(name: &str, tree: &Path) {
    let before = content(tree);
    for extra in [&[][..], &["--few"][..]] {
        assert_eq!(install(extra, tree).0, Some(0), "{name}");
        assert_eq!(install(&["--check"], tree).0, Some(0), "{name}");
        let once = content(tree);
        assert!(once.len() > before.len(), "{name}");
        assert_eq!(install(extra, tree).0, Some(0), "{name}");
        assert_eq!(once, content(tree), "{name}: twice is once");
        assert_eq!(install(&["--remove"], tree).0, Some(0), "{name}");
        assert_eq!(before, content(tree), "{name}: after the removal");
    }
}

#[test]
fn what_a_user_wrote_comes_back_to_the_byte() {
    let list = "style_contact_model_user.whitelist";
    for (name, file, text) in [
        ("no_final_newline_in_cmake", "CMakeLists.txt", "PROJECT(X)"),
        (
            "our_name_in_cmake",
            "CMakeLists.txt",
            "# for ellgran\nPROJECT(X)\n",
        ),
        (
            "no_final_newline_in_the_list",
            list,
            "GRAN_MODEL(A, B, C, D, E)",
        ),
        (
            "our_name_in_the_list",
            list,
            "// for ellgran\nGRAN_MODEL(A, B, C, D, E)\n",
        ),
        (
            "our_own_line_in_the_list",
            list,
            "GRAN_MODEL(NFD, TANGENTIAL_TFD, COHESION_OFF, ROLLING_OFF, SURFACE_ELLIPSOID)\n",
        ),
        ("an_empty_list", list, ""),
        (
            "no_final_newline_in_the_dump",
            "dump_mesh_vtk.h",
            "class A;",
        ),
        (
            "our_name_in_the_dump",
            "dump_mesh_vtk.cpp",
            "/* ellgran */ int a;\n",
        ),
        (
            "a_mend_of_their_own",
            "finish.cpp",
            "if (list->numneigh != 0) {}  // as ellgran has it\n",
        ),
        (
            "a_list_of_their_own",
            "style_contact_model.whitelist",
            "GRAN_MODEL(A, B, C, D, E)",
        ),
        (
            "a_makefile_of_another_make",
            "MAKE/Makefile.auto",
            "EXTRA_ADDLIBS=\nX := $(ellgran)",
        ),
    ] {
        let tree = tree(name, "3.8.0\n");
        fs::write(tree.join("src").join(file), text).unwrap();
        comes_back(name, &tree);
    }
}

#[test]
fn what_a_user_changed_since_stays_and_our_lines_go() {
    let tree = tree("changed_since", "3.8.0\n");
    let before = content(&tree);
    assert_eq!(install(&[], &tree).0, Some(0));
    let files = [
        "CMakeLists.txt",
        "finish.cpp",
        "utils.h",
        "dump_particle.cpp",
        "write_data.cpp",
        "atom_vec_superquadric.cpp",
        "mesh_module_stress_servo.h",
        "mesh_module_stress_servo.cpp",
        "fix_move_mesh.h",
        "fix_move_mesh.cpp",
        "modify.cpp",
        "run.cpp",
        "domain.cpp",
        "fix_insert_stream.cpp",
        "replicate.cpp",
        "fix_wall_gran_base.h",
        "fix_ave_euler.cpp",
        "input_mesh_tri.cpp",
        "error.cpp",
        "MAKE/Makefile.auto",
        "style_contact_model_user.whitelist",
    ];
    for file in files {
        let path = tree.join("src").join(file);
        let text = fs::read_to_string(&path).unwrap();
        fs::write(&path, format!("{text}# mine, for ellgran\n")).unwrap();
    }
    assert_eq!(install(&["--remove"], &tree).0, Some(0));
    let after = content(&tree);
    for file in files {
        let path = tree.join("src").join(file).to_string_lossy().into_owned();
        let mut expected = before.get(&path).cloned().unwrap_or_default();
        expected.extend(b"# mine, for ellgran\n");
        assert_eq!(
            String::from_utf8_lossy(&after[&path]),
            String::from_utf8_lossy(&expected),
            "{file}"
        );
    }
    assert_eq!(after.len(), before.len() + 1, "only the user's list is new");
}

/// LIGGGHTS' build writes the list of all combinations, ours among them, where there was none.
#[test]
fn a_list_that_a_build_wrote_loses_our_models() {
    let tree = tree("built", "3.8.0\n");
    assert_eq!(install(&[], &tree).0, Some(0));
    let list = tree.join("src/style_contact_model.whitelist");
    let theirs = "GRAN_MODEL(HERTZ, TANGENTIAL_OFF, COHESION_OFF, ROLLING_OFF, SURFACE_DEFAULT)\n";
    let ours = "GRAN_MODEL(HERTZ, TANGENTIAL_OFF, COHESION_OFF, ROLLING_OFF, SURFACE_ELLIPSOID)\n\
                GRAN_MODEL(NFD, TANGENTIAL_OFF, COHESION_OFF, ROLLING_OFF, SURFACE_DEFAULT)\n";
    fs::write(&list, format!("{theirs}{ours}{theirs}")).unwrap();
    assert_eq!(install(&["--remove"], &tree).0, Some(0));
    assert_eq!(fs::read_to_string(&list).unwrap(), theirs.repeat(2));
}

#[test]
fn words_that_contradict_each_other_change_nothing() {
    let tree = tree("words", "3.8.0\n");
    assert_eq!(install(&[], &tree).0, Some(0));
    let installed = content(&tree);
    for words in [
        &["--check", "--remove"][..],
        &["--remove", "--check"],
        &["--remove", "--few"],
        &["--few", "--check"],
        &["--nonsense"],
    ] {
        let (status, text) = install(words, &tree);
        assert_eq!(status, Some(2), "{words:?}: {text}");
        assert!(text.starts_with("install: "), "{text}");
        assert_eq!(installed, content(&tree), "{words:?}");
    }
}

#[test]
fn twice_is_once_and_removal_leaves_nothing() {
    for extra in [&[][..], &["--few"][..]] {
        let tree = tree(&format!("tree{}", extra.len()), "3.8.0\n");
        fs::write(
            tree.join("src/style_contact_model_user.whitelist"),
            "GRAN_MODEL(A, B, C, D, E)\n",
        )
        .unwrap();
        let before = content(&tree);
        assert_eq!(install(&["--check"], &tree).0, Some(1));
        assert_eq!(install(extra, &tree).0, Some(0));
        let once = content(&tree);
        assert!(once.len() > before.len());
        assert_eq!(install(extra, &tree).0, Some(0));
        assert_eq!(once, content(&tree));
        assert_eq!(install(&["--check"], &tree).0, Some(0));
        assert_eq!(install(&["--remove"], &tree).0, Some(0));
        assert_eq!(before, content(&tree));
        assert_eq!(install(&["--remove"], &tree).0, Some(0));
        assert_eq!(before, content(&tree));
    }
}

#[test]
fn another_version_is_refused() {
    let tree = tree("old", "3.7.0\n");
    let before = content(&tree);
    let (status, text) = install(&[], &tree);
    assert_eq!(status, Some(2));
    assert!(text.contains("3.7.0") && text.contains("3.8.0"), "{text}");
    assert_eq!(before, content(&tree));
    assert_eq!(install(&[], Path::new("/nowhere")).0, Some(2));
}
