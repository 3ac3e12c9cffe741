//! What `setup.sh` does, and says, on machines that have this and that: a folder of stand-ins for apt and
//! dpkg is its whole PATH.

mod support;

use std::fs;
use std::os::unix::fs::{PermissionsExt, symlink};
use std::process::Command;

use support::pictures::in_package;
use tempfile::TempDir;

/// What the script needs beside apt, dpkg and what is faked: tools that every machine has.
const TOOLS: [&str; 8] = ["cat", "cut", "dirname", "env", "head", "paste", "sed", "sort"];

/// The newest Rust that apt has is new enough, and as Debian 13 has it.
const RUSTC: &str = "1.85.1+dfsg1-1+deb13u1";
const RUSTC_WEB: &str = "1.96.0+dfsg1-1~deb13u1+b1";

/// A Debian on which all packages are installed, but no Rust, and root is at work.
struct Machine {
    root: TempDir,
}

impl Machine {
    fn new() -> Self {
        let machine = Self { root: tempfile::tempdir().expect("a folder") };
        fs::create_dir(machine.root.path().join("bin")).expect("new");
        fs::create_dir(machine.root.path().join("front")).expect("new");
        for tool in TOOLS {
            let path = ["/usr/bin", "/bin"].map(|folder| format!("{folder}/{tool}"));
            let path = path.iter().find(|path| fs::exists(path).is_ok_and(|there| there));
            let link = machine.root.path().join("bin").join(tool);
            symlink(path.expect("a usual place"), link).expect("new");
        }
        // `bin` stands for /usr/bin.
        machine.tool("bin/readlink", r#"case $2 in */bin) echo /usr/bin ;; *) echo "$2" ;; esac"#);
        machine.tool("bin/id", "echo 0");
        machine.tool("bin/dpkg-query", "echo installed");
        machine
            .tool("bin/dpkg", r#"[ "$(printf '%s\n' "$2" "$4" | sort -V | head -n 1)" = "$4" ]"#);
        machine.apt_has(RUSTC, RUSTC_WEB);
        machine.apt_would("");
        machine
    }

    /// Puts a shell script into a folder of the machine.
    fn tool(&self, name: &str, script: &str) {
        let path = self.root.path().join(name);
        fs::write(&path, format!("#!/bin/sh\n{script}\n")).expect("writable");
        fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).expect("ours");
    }

    fn cargo(&self, folder: &str, version: &str) {
        self.tool(&format!("{folder}/cargo"), &format!("echo 'cargo {version} (0123456789 2026)'"));
    }

    fn apt_has(&self, rustc: &str, rustc_web: &str) {
        // In other languages, apt has other words.
        self.tool(
            "bin/apt-cache",
            &format!(
                "case $LC_ALL:$2 in
                C:rustc) echo '  Candidate: {rustc}' ;;
                C:rustc-web) echo '  Candidate: {rustc_web}' ;;
                *) echo '  Installationskandidat: 2' ;;
                esac"
            ),
        );
    }

    /// What `apt-get install` does, by what its simulation says; else it echoes how it is called.
    fn apt_would(&self, plan: &str) {
        let script = format!("case $2 in -s) echo '{plan}' ;; *) echo \"apt-get $*\" ;; esac");
        self.tool("bin/apt-get", &script);
    }

    /// Runs the script: what it printed, or what it complained of.
    fn set_up(&self) -> Result<String, String> {
        let folder = |name: &str| self.root.path().join(name).display().to_string();
        let output = Command::new("/bin/sh")
            .arg(in_package("setup.sh"))
            .env("PATH", format!("{}:{}", folder("front"), folder("bin")))
            .output()
            .expect("a shell");
        let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("text");
        let (printed, complaint) = (text(output.stdout), text(output.stderr));
        let complaint = complaint.replace(&folder(""), "/");
        match output.status.code() {
            Some(0) => {
                assert_eq!(complaint, "", "with {printed}");
                Ok(printed)
            }
            Some(1) => {
                assert!(!printed.contains("install"), "{printed}{complaint}");
                Err(complaint)
            }
            _ => panic!("{printed}{complaint}"),
        }
    }
}

/// The version that Cargo.toml asks for.
const NEEDED: &str = env!("CARGO_PKG_RUST_VERSION");

#[test]
fn nothing_is_done_where_nothing_is_missing() {
    let machine = Machine::new();
    machine.cargo("front", &format!("{NEEDED}.0"));
    assert_eq!(machine.set_up(), Ok(String::new()));
    // What comes later in PATH does not matter.
    machine.cargo("bin", "1.63.0");
    assert_eq!(machine.set_up(), Ok(String::new()));
}

#[test]
fn a_fresh_machine_gets_the_first_rust_of_apt_that_is_new_enough() {
    let machine = Machine::new();
    let installs = |packages: &str| {
        Ok(format!("apt-get update -q\napt-get install -qy --no-install-recommends {packages}\n"))
    };
    assert_eq!(machine.set_up(), installs("cargo-web rustc-web"));
    machine.apt_has("1.100.0+dfsg1-1", RUSTC_WEB);
    assert_eq!(machine.set_up(), installs("cargo rustc"));
    machine.tool("bin/dpkg-query", "case $4 in gcc) exit 1 ;; *) echo installed ;; esac");
    assert_eq!(machine.set_up(), installs("gcc cargo rustc"));
    machine.cargo("front", "1.100.0");
    assert_eq!(machine.set_up(), installs("gcc"));
}

#[test]
fn an_older_rust_of_apts_is_replaced_but_not_without_a_word() {
    let machine = Machine::new();
    machine.cargo("bin", "1.85.1");
    machine.apt_would(
        "Remv rustc [1.85.1] [cargo:amd64 ]\nInst rustc-web (1.96)\nRemv cargo [1.85.1]\nConf rustc-web (1.96)",
    );
    let expected = format!(
        "apt-get update -q
setup.sh: Telamon needs Rust {NEEDED} or newer, so these packages of apt's older one are replaced: cargo rustc.
setup.sh: In their place come cargo-web and rustc-web {RUSTC_WEB}. Nothing else is removed, but an
setup.sh: older clippy may not work with them: rust-web-clippy and rustfmt-web are theirs.
apt-get install -qy --no-install-recommends cargo-web rustc-web
"
    );
    assert_eq!(machine.set_up(), Ok(expected));
}

#[test]
fn nothing_else_is_removed() {
    let machine = Machine::new();
    machine.apt_would("Remv rustc [1.85.1]\nRemv needs-old-rustc [1]");
    let expected = "setup.sh: apt would remove needs-old-rustc rustc for that, so nothing was installed. If that is all right:
setup.sh: apt-get install --no-install-recommends cargo-web rustc-web
";
    assert_eq!(machine.set_up(), Err(expected.to_owned()));

    machine.apt_would("Remv rustup [1.27.1]");
    let expected = format!(
        "setup.sh: apt's rustup is here, but without Rust {NEEDED} or newer: rustup default stable\n"
    );
    assert_eq!(machine.set_up(), Err(expected));

    // Not for Embree's sake either, if Rust is not what is missing.
    machine.cargo("front", "1.100.0");
    machine.tool("bin/dpkg-query", "case $4 in libembree-dev) exit 1 ;; *) echo installed ;; esac");
    machine.apt_would("Remv cargo [1.85.1]");
    let expected =
        "setup.sh: apt would remove cargo for that, so nothing was installed. If that is all right:
setup.sh: apt-get install --no-install-recommends libembree-dev
";
    assert_eq!(machine.set_up(), Err(expected.to_owned()));
}

#[test]
fn an_apt_that_knows_only_older_rust_is_an_error() {
    let machine = Machine::new();
    machine.apt_has("1.63.0+dfsg1-2", "1.85.0+dfsg3-1~deb12u3");
    let expected = format!(
        "setup.sh: Telamon needs Rust {NEEDED} or newer, but apt has rustc 1.63.0+dfsg1-2 and rustc-web
setup.sh: 1.85.0+dfsg3-1~deb12u3. Debian's security updates have a newer one (are they among apt's
setup.sh: sources?), and so has https://rustup.rs.
"
    );
    assert_eq!(machine.set_up(), Err(expected));
}

#[test]
fn what_apt_cannot_install_is_an_error() {
    let machine = Machine::new();
    let fails =
        "case $2 in -s) echo unmet dependencies; exit 100 ;; *) echo \"apt-get $*\" ;; esac";
    machine.tool("bin/apt-get", fails);
    let expected =
        "setup.sh: apt cannot install: cargo-web rustc-web\nsetup.sh: unmet dependencies\n";
    assert_eq!(machine.set_up(), Err(expected.to_owned()));
}

#[test]
fn an_older_cargo_before_that_of_apt_is_an_error() {
    let machine = Machine::new();
    machine.cargo("front", "1.80.0");
    let expected = format!(
        "setup.sh: Telamon needs cargo {NEEDED} or newer, but /front/cargo says: cargo 1.80.0 (0123456789 2026)
setup.sh: It comes before /usr/bin in PATH, so apt's would not be found: update or remove that one.
"
    );
    assert_eq!(machine.set_up(), Err(expected));
}

#[test]
fn somebody_without_sudo_is_told_what_is_missing() {
    let machine = Machine::new();
    machine.tool("bin/id", "echo 1000");
    let expected = format!(
        "setup.sh: something is to be installed, and there is no sudo here: run this as root.
setup.sh: Missing: Rust {NEEDED} or newer
"
    );
    assert_eq!(machine.set_up(), Err(expected));

    machine.tool("bin/sudo", r#"echo "sudo $*""#);
    let expected = "sudo apt-get update -q
sudo env DEBIAN_FRONTEND=noninteractive apt-get install -qy --no-install-recommends cargo-web rustc-web
";
    assert_eq!(machine.set_up(), Ok(expected.to_owned()));
}

#[test]
fn without_apt_the_script_says_what_is_needed() {
    let machine = Machine::new();
    fs::remove_file(machine.root.path().join("bin/apt-get")).expect("it was there");
    let complaint = machine.set_up().expect_err("no apt");
    assert!(complaint.starts_with("setup.sh: there is no apt-get here."), "{complaint}");
    assert!(complaint.contains("cargo run --no-default-features"), "{complaint}");
}
