// SPDX-License-Identifier: MIT OR Apache-2.0
//! An upstream source tarball, or what is in a binary package, out of Debian's archive, wherever this machine's own apt
//! configuration finds that archive. apt runs on a private configuration, so the machine's own package lists stay as they are.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

use anyhow::{bail, Context, Result};

use crate::process::{find_program, output_of, run_logged};
use crate::progress::Progress;

/// One entry of the machine's apt sources, from either file format.
#[derive(Debug, Clone, PartialEq, Default)]
struct Entry {
    uris: Vec<String>,
    suites: Vec<String>,
    components: Vec<String>,
    /// deb822 fields to carry over as they are: keyring, trust, date checks.
    options: Vec<(String, String)>,
}

/// A source package in one suite.
pub struct Package {
    name: String,
    pub version: String,
    /// Bytes of the upstream tarball, when the index says.
    size: Option<u64>,
    apt: PrivateApt,
}

/// Options that make the archive trusted, or usable, and so must follow the address.
const CARRIED: [&str; 5] = [
    "Signed-By",
    "Trusted",
    "Check-Valid-Until",
    "Check-Date",
    "Allow-Insecure",
];

/// Suites of the main archive by the names that Debian gives them; the machine's own code name is added.
const SUITES: [&str; 10] = [
    "bookworm",
    "trixie",
    "forky",
    "sid",
    "stable",
    "testing",
    "unstable",
    "oldstable",
    "oldoldstable",
    "duke",
];

/// The first suite's that has it. A suite that cannot be read, because it does not exist yet or any more, counts only
/// if no other has the package.
pub fn find_in(name: &str, upstream: &str, suites: &[&str]) -> Result<Option<Package>> {
    let mut failure = None;
    for suite in suites {
        match find(name, upstream, suite) {
            Ok(Some(package)) => return Ok(Some(package)),
            Ok(None) => {}
            Err(error) => failure = Some(error),
        }
    }
    failure.map_or(Ok(None), Err)
}

/// The versions of source package `name` in `suite`.
pub fn versions(name: &str, suite: &str) -> Result<Vec<String>> {
    let apt = indexed(suite, format!("Looking for {name} in {suite}"))?;
    let shown = output_of(apt.command("apt-cache").args(["showsrc", name])).unwrap_or_default();
    Ok(shown_versions(&shown, name))
}

fn shown_versions(shown: &str, name: &str) -> Vec<String> {
    let package = format!("Package: {name}");
    shown
        .split("\n\n")
        .filter(|paragraph| paragraph.lines().any(|line| line == package))
        .filter_map(|paragraph| {
            let version = paragraph
                .lines()
                .find_map(|line| line.strip_prefix("Version: "));
            version.map(str::to_string)
        })
        .collect()
}

/// The newest version of source package `name` in `suite` whose version starts with `upstream`.
fn find(name: &str, upstream: &str, suite: &str) -> Result<Option<Package>> {
    let apt = indexed(suite, format!("Looking for {name} {upstream} in {suite}"))?;
    let shown = output_of(apt.command("apt-cache").args(["showsrc", name])).unwrap_or_default();
    Ok(
        newest(&shown, name, upstream).map(|(version, size)| Package {
            name: name.to_string(),
            version,
            size,
            apt,
        }),
    )
}

/// An apt that has read the index of sources of `suite`.
fn indexed(suite: &str, title: String) -> Result<PrivateApt> {
    need_tools(&["apt-get", "apt-cache", "apt-config"])?;
    let apt = PrivateApt::new(&machine_archive()?, suite, "deb-src")?;
    apt.update(title)?;
    Ok(apt)
}

impl Package {
    /// Downloads the upstream tarball into `directory`; apt has checked its hash against the signed index.
    pub fn download(&self, directory: &Path) -> Result<PathBuf> {
        fs::create_dir_all(directory)?;
        let mut progress = Progress::start(format!("Fetching {} {}", self.name, self.version));
        let log = self.apt.directory.path().join("source.log");
        let output = fs::File::create(&log)?;
        let mut child = self
            .apt
            .command("apt-get")
            .args(["source", "-q", "--download-only", "--tar-only"])
            .arg(format!("{}={}", self.name, self.version))
            .current_dir(directory)
            .stdin(Stdio::null())
            .stdout(output.try_clone()?)
            .stderr(output)
            .spawn()?;
        let status = loop {
            if let Some(status) = child.try_wait()? {
                break status;
            }
            std::thread::sleep(Duration::from_millis(200));
            let got = size_of_files(directory);
            let note = match self.size {
                Some(size) => format!("{} of {} MB", got / 1_000_000, size / 1_000_000),
                None => format!("{} MB", got / 1_000_000),
            };
            progress.update(self.size.map(|size| got as f64 / size.max(1) as f64), &note);
        };
        if !status.success() {
            progress.clear();
            bail!(
                "apt-get source {}={}: {status}\n{}",
                self.name,
                self.version,
                fs::read_to_string(&log).unwrap_or_default().trim_end()
            );
        }
        progress.finish();
        fs::read_dir(directory)?
            .filter_map(|entry| Some(entry.ok()?.path()))
            .find(|path| path.to_string_lossy().contains(".orig.tar."))
            .with_context(|| format!("apt-get left no tarball in {}", directory.display()))
    }
}

fn need_tools(tools: &[&str]) -> Result<()> {
    match tools.iter().find(|tool| find_program(tool).is_none()) {
        Some(tool) => bail!("{tool} is not on this system"),
        None => Ok(()),
    }
}

/// The binary packages of this machine's own release.
pub struct Packages {
    apt: PrivateApt,
}

impl Packages {
    pub fn of_this_system() -> Result<Self> {
        Self::read("")
    }

    /// Those of the same release for another machine, by Debian's name of it: `arm64`. None counts as installed.
    pub fn of_architecture(name: &str) -> Result<Self> {
        Self::read(&format!(
            "APT::Architecture \"{name}\";\n\
             #clear APT::Architectures;\n\
             APT::Architectures:: \"{name}\";\n\
             Dir::State::status \"/dev/null\";\n"
        ))
    }

    fn read(configuration: &str) -> Result<Self> {
        need_tools(&["apt-get", "apt-cache", "apt-config", "dpkg-deb"])?;
        let archive = machine_archive()?;
        let suite = archive
            .suites
            .first()
            .context("an archive without a suite")?;
        let apt = PrivateApt::new(&archive, suite, "deb")?;
        let file = apt.directory.path().join("apt.conf");
        let common = fs::read_to_string(&file)?;
        fs::write(&file, common + configuration)?;
        apt.update(format!("Reading the packages of {suite}"))?;
        Ok(Packages { apt })
    }

    /// The files of these packages and of all that they depend on, as they would be installed below `root`.
    pub fn unpack_with_dependencies(&self, names: &[&str], root: &Path) -> Result<()> {
        output_of(
            self.apt
                .command("apt-get")
                .args(["install", "-q", "-y", "--download-only"])
                .arg("--no-install-recommends")
                .args(names),
        )?;
        let archives = self.apt.directory.path().join("cache/archives");
        for entry in fs::read_dir(&archives)? {
            let path = entry?.path();
            if path.extension().is_some_and(|extension| extension == "deb") {
                output_of(Command::new("dpkg-deb").arg("-x").arg(path).arg(root))?;
            }
        }
        Ok(())
    }

    /// Names of the packages that `name` depends on.
    pub fn depends(&self, name: &str) -> Result<Vec<String>> {
        let shown = output_of(self.apt.command("apt-cache").args(["depends", name]))?;
        Ok(shown
            .lines()
            .filter_map(|line| line.trim().strip_prefix("Depends: "))
            .map(str::to_string)
            .collect())
    }

    /// Its files, as they would be installed below `root`; apt has checked its hash against the signed index.
    pub fn unpack(&self, name: &str, root: &Path) -> Result<()> {
        let directory = tempfile::Builder::new().prefix("ellgran-deb-").tempdir()?;
        output_of(
            self.apt
                .command("apt-get")
                .args(["download", "-q", name])
                .current_dir(directory.path()),
        )?;
        let package = fs::read_dir(directory.path())?
            .filter_map(|entry| Some(entry.ok()?.path()))
            .find(|path| path.extension().is_some_and(|extension| extension == "deb"))
            .with_context(|| format!("apt-get download {name} left no package"))?;
        output_of(Command::new("dpkg-deb").arg("-x").arg(package).arg(root))?;
        Ok(())
    }
}

/// apt with lists, cache and sources of its own, in a directory that goes when this does.
struct PrivateApt {
    directory: tempfile::TempDir,
}

impl PrivateApt {
    /// `kind` is `deb` or `deb-src`.
    fn new(archive: &Entry, suite: &str, kind: &str) -> Result<Self> {
        let directory = tempfile::Builder::new().prefix("ellgran-apt-").tempdir()?;
        let base = directory.path();
        for name in ["sources", "lists/partial", "cache/archives/partial"] {
            fs::create_dir_all(base.join(name))?;
        }
        fs::write(
            base.join("sources").join("ellgran.sources"),
            stanza(archive, suite, kind),
        )?;
        let at = |name: &str| base.join(name).display().to_string();
        fs::write(
            base.join("apt.conf"),
            format!(
                // The machine's hooks clean its own cache, which is not ours to touch. As root apt would hand the
                // download to a user who may not enter our directory.
                "#clear APT::Update::Post-Invoke;\n\
                 #clear APT::Update::Post-Invoke-Success;\n\
                 #clear APT::Update::Pre-Invoke;\n\
                 Dir::Etc::sourcelist \"/dev/null\";\n\
                 Dir::Etc::sourceparts \"{}\";\n\
                 Dir::State::lists \"{}\";\n\
                 Dir::Cache \"{}\";\n\
                 APT::Sandbox::User \"\";\n\
                 Acquire::Languages \"none\";\n",
                at("sources"),
                at("lists"),
                at("cache")
            ),
        )?;
        Ok(PrivateApt { directory })
    }

    fn update(&self, title: String) -> Result<()> {
        let mut progress = Progress::start(title);
        let log = self.directory.path().join("update.log");
        let result = run_logged(
            self.command("apt-get").args(["update", "-q"]),
            &log,
            |line| progress.update(None, line),
        );
        match result {
            Ok(()) => progress.finish(),
            Err(_) => progress.clear(),
        }
        result
    }

    fn command(&self, program: &str) -> Command {
        let mut command = Command::new(program);
        command
            .arg("-c")
            .arg(self.directory.path().join("apt.conf"))
            .env("LC_ALL", "C");
        command
    }
}

/// The first entry of this machine's configuration that is Debian's main archive.
fn machine_archive() -> Result<Entry> {
    let shell = output_of(Command::new("apt-config").args([
        "shell",
        "LIST",
        "Dir::Etc::sourcelist/f",
        "PARTS",
        "Dir::Etc::sourceparts/d",
    ]))?;
    let mut files = Vec::new();
    if let Some(list) = shell_value(&shell, "LIST") {
        files.push(PathBuf::from(list));
    }
    if let Some(parts) = shell_value(&shell, "PARTS") {
        let mut found: Vec<PathBuf> = fs::read_dir(parts)
            .into_iter()
            .flatten()
            .filter_map(|entry| Some(entry.ok()?.path()))
            .collect();
        found.sort();
        files.extend(found);
    }
    let mut entries = Vec::new();
    for file in files {
        let Ok(text) = fs::read_to_string(&file) else {
            continue;
        };
        match file.extension().and_then(|extension| extension.to_str()) {
            Some("sources") => entries.extend(parse_deb822(&text)),
            Some("list") => entries.extend(parse_one_line(&text)),
            _ => {}
        }
    }
    let release = fs::read_to_string("/etc/os-release").unwrap_or_default();
    let code_name = shell_value(&release, "VERSION_CODENAME").unwrap_or_default();
    main_archive(&entries, &code_name)
        .context("this machine's apt configuration names no main archive of Debian")
}

/// A variable of a file of shell assignments, with or without quotes.
fn shell_value(text: &str, name: &str) -> Option<String> {
    text.lines()
        .filter_map(|line| line.split_once('='))
        .find(|(key, _)| key.trim() == name)
        .map(|(_, value)| value.trim().trim_matches(['"', '\'']).to_string())
        .filter(|value| !value.is_empty())
}

fn main_archive(entries: &[Entry], code_name: &str) -> Option<Entry> {
    entries
        .iter()
        .find(|entry| {
            // bookworm-updates and bookworm-security are other archives, and know no other suite.
            entry.components.iter().any(|name| name == "main")
                && entry
                    .suites
                    .iter()
                    .any(|suite| SUITES.contains(&suite.as_str()) || suite == code_name)
                && entry.uris.iter().any(|uri| !uri.starts_with("cdrom:"))
        })
        .cloned()
}

/// The same archive, packages of one kind of a suite.
fn stanza(archive: &Entry, suite: &str, kind: &str) -> String {
    let uris: Vec<&str> = archive
        .uris
        .iter()
        .map(String::as_str)
        .filter(|uri| !uri.starts_with("cdrom:"))
        .collect();
    let mut text = format!(
        "Types: {kind}\nURIs: {}\nSuites: {suite}\nComponents: main\n",
        uris.join(" ")
    );
    for (name, value) in &archive.options {
        text.push_str(&format!("{name}: {value}\n"));
    }
    text
}

/// The `*.sources` format: stanzas of fields, a value going on over indented lines.
fn parse_deb822(text: &str) -> Vec<Entry> {
    let mut entries = Vec::new();
    let mut fields: Vec<(String, String)> = Vec::new();
    for line in text.lines().chain([""]) {
        if line.starts_with('#') {
            continue;
        }
        if line.trim().is_empty() {
            entries.extend(deb822_entry(&fields));
            fields.clear();
        } else if line.starts_with([' ', '\t']) {
            if let Some((_, value)) = fields.last_mut() {
                // Kept line by line: the value may be a whole key.
                value.push('\n');
                value.push_str(line);
            }
        } else if let Some((name, value)) = line.split_once(':') {
            fields.push((name.trim().to_string(), value.trim().to_string()));
        }
    }
    entries
}

fn deb822_entry(fields: &[(String, String)]) -> Option<Entry> {
    let words = |name: &str| -> Vec<String> {
        fields
            .iter()
            .filter(|(key, _)| key.eq_ignore_ascii_case(name))
            .flat_map(|(_, value)| value.split_whitespace())
            .map(str::to_string)
            .collect()
    };
    let disabled = words("Enabled")
        .first()
        .is_some_and(|value| ["no", "false", "0"].contains(&value.to_lowercase().as_str()));
    if disabled || words("Types").is_empty() {
        return None;
    }
    Some(Entry {
        uris: words("URIs"),
        suites: words("Suites"),
        components: words("Components"),
        options: CARRIED
            .iter()
            .filter_map(|name| {
                let (_, value) = fields
                    .iter()
                    .find(|(key, _)| key.eq_ignore_ascii_case(name))?;
                Some((name.to_string(), value.clone()))
            })
            .collect(),
    })
}

/// The `*.list` format: `deb [option=value ...] uri suite component ...`.
fn parse_one_line(text: &str) -> Vec<Entry> {
    text.lines().filter_map(one_line_entry).collect()
}

fn one_line_entry(line: &str) -> Option<Entry> {
    let line = line.split('#').next().unwrap_or_default().trim();
    let rest = line
        .strip_prefix("deb-src")
        .or_else(|| line.strip_prefix("deb"))?;
    if !rest.starts_with([' ', '\t']) {
        return None;
    }
    let rest = rest.trim_start();
    let (options, rest) = match rest.strip_prefix('[') {
        Some(rest) => rest.split_once(']')?,
        None => ("", rest),
    };
    let mut words = rest.split_whitespace().map(str::to_string);
    let uri = words.next()?;
    let suite = words.next()?;
    Some(Entry {
        uris: vec![uri],
        suites: vec![suite],
        components: words.collect(),
        options: options
            .split_whitespace()
            .filter_map(|option| {
                let (key, value) = option.split_once('=')?;
                let name = CARRIED.iter().find(|name| name.eq_ignore_ascii_case(key))?;
                Some((name.to_string(), value.replace(',', " ")))
            })
            .collect(),
    })
}

/// The version, and the size of its upstream tarball, out of what `apt-cache showsrc` prints.
fn newest(shown: &str, name: &str, upstream: &str) -> Option<(String, Option<u64>)> {
    shown.split("\n\n").find_map(|paragraph| {
        let field = |key: &str| {
            paragraph
                .lines()
                .find_map(|line| line.strip_prefix(key)?.strip_prefix(": "))
        };
        let version = field("Version")?;
        if field("Package")? != name || !version.starts_with(upstream) {
            return None;
        }
        let size = paragraph
            .lines()
            .filter(|line| line.starts_with(' '))
            .find_map(|line| {
                let mut words = line.split_whitespace();
                let (_hash, size, file) = (words.next()?, words.next()?, words.next()?);
                let tarball = file.contains(".orig.tar.") && !file.ends_with(".asc");
                size.parse().ok().filter(|_| tarball)
            });
        Some((version.to_string(), size))
    })
}

/// apt writes into a `partial` name first, so everything there counts.
fn size_of_files(directory: &Path) -> u64 {
    fs::read_dir(directory)
        .into_iter()
        .flatten()
        .filter_map(|entry| Some(entry.ok()?.metadata().ok()?.len()))
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    const DEB822: &str = "\
Types: deb
# the archive
URIs: http://mirror.example/linux
Suites: bookworm-security
Components: main
Signed-By: /usr/share/keyrings/security.gpg

Enabled: no
Types: deb
URIs: http://off.example/linux
Suites: bookworm
Components: main

types: deb deb-src
uris: http://mirror.example/linux
# a comment amid the fields
suites: bookworm bookworm-updates
components: contrib
 main
signed-by:
 -----BEGIN PGP PUBLIC KEY BLOCK-----
 .
 abc
 -----END PGP PUBLIC KEY BLOCK-----
";

    #[test]
    fn deb822_stanzas_are_read() {
        let entries = parse_deb822(DEB822);
        assert_eq!(entries.len(), 2);
        assert_eq!(entries[0].suites, ["bookworm-security"]);
        assert_eq!(entries[1].suites, ["bookworm", "bookworm-updates"]);
        assert_eq!(entries[1].components, ["contrib", "main"]);
        assert_eq!(entries[1].options[0].0, "Signed-By");
        assert!(entries[1].options[0].1.contains("\n .\n abc\n"));
    }

    #[test]
    fn one_line_entries_are_read() {
        let text = "\
# deb http://off.example/linux bookworm main
deb cdrom:[a disc]/ bookworm main
deb [arch=amd64 signed-by=/usr/share/keyrings/a.gpg,/b.gpg trusted=yes] http://mirror.example/linux trixie main contrib # why
deb-src http://mirror.example/linux trixie main
debris http://mirror.example trixie main
deb http://flat.example ./
";
        let entries = parse_one_line(text);
        assert_eq!(entries.len(), 4);
        assert_eq!(
            entries[1],
            Entry {
                uris: vec!["http://mirror.example/linux".into()],
                suites: vec!["trixie".into()],
                components: vec!["main".into(), "contrib".into()],
                options: vec![
                    (
                        "Signed-By".into(),
                        "/usr/share/keyrings/a.gpg /b.gpg".into()
                    ),
                    ("Trusted".into(), "yes".into()),
                ],
            }
        );
        assert_eq!(entries[3].suites, ["./"]);
    }

    #[test]
    fn the_main_archive_is_the_one_with_a_plain_suite() {
        let entries = parse_deb822(DEB822);
        let archive = main_archive(&entries, "").unwrap();
        assert_eq!(archive, entries[1]);
        assert_eq!(main_archive(&entries[..1], "bookworm"), None);
        let own = parse_one_line("deb http://mirror.example/linux newname main");
        assert!(main_archive(&own, "").is_none());
        assert!(main_archive(&own, "newname").is_some());
    }

    #[test]
    fn another_suite_keeps_the_keyring() {
        let entries = parse_one_line(
            "deb [signed-by=/usr/share/keyrings/a.gpg] http://mirror.example/linux stable main",
        );
        assert_eq!(
            stanza(&entries[0], "sid", "deb-src"),
            "Types: deb-src\nURIs: http://mirror.example/linux\nSuites: sid\nComponents: main\nSigned-By: /usr/share/keyrings/a.gpg\n"
        );
    }

    #[test]
    fn shell_assignments_are_read_with_and_without_quotes() {
        let text = "ID=debian\nVERSION_CODENAME=bookworm\nLIST='/etc/apt/sources.list'\nEMPTY=''\n";
        assert_eq!(
            shell_value(text, "VERSION_CODENAME").as_deref(),
            Some("bookworm")
        );
        assert_eq!(
            shell_value(text, "LIST").as_deref(),
            Some("/etc/apt/sources.list")
        );
        assert_eq!(shell_value(text, "EMPTY"), None);
    }

    #[test]
    fn the_version_and_its_size_come_from_the_index() {
        let shown = "\
Package: engine
Version: 20260704+dfsg-2
Files:
 40ded6 3000 engine_20260704+dfsg-2.dsc
 b635f5 213748522 engine_20260704+dfsg.orig.tar.gz
Package-List:
 engine deb science optional

Package: engine
Version: 20250204+dfsg.1-2
Files:
 671165 132367436 engine_20250204+dfsg.1.orig.tar.xz
";
        assert_eq!(
            newest(shown, "engine", "20260704"),
            Some(("20260704+dfsg-2".into(), Some(213_748_522)))
        );
        assert_eq!(
            newest(shown, "engine", "20250204"),
            Some(("20250204+dfsg.1-2".into(), Some(132_367_436)))
        );
        assert_eq!(
            shown_versions(shown, "engine"),
            ["20260704+dfsg-2", "20250204+dfsg.1-2"]
        );
        assert_eq!(newest(shown, "engine", "2027"), None);
        assert_eq!(newest(shown, "other", "20250204"), None);
    }
}
