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
    fs::create_dir_all(&src).unwrap();
    for (file, text) in [
        ("version_liggghts.txt", version),
        ("version_liggghts_branch.txt", "LIGGGHTS-PUBLIC\n"),
        ("CMakeLists.txt", "PROJECT(X)\n"),
        ("finish.cpp", "if (list->numneigh > 0) {}\n"),
        ("dump_mesh_vtk.h", "class A;\n"),
        ("dump_mesh_vtk.cpp", "int a;\n"),
    ] {
        fs::write(src.join(file), text).unwrap();
    }
    tree
}

fn content(tree: &Path) -> BTreeMap<String, Vec<u8>> {
    fs::read_dir(tree.join("src"))
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .map(|path| {
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            (name, fs::read(path).unwrap())
        })
        .collect()
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
