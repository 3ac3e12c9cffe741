//! How much memory this process may use, as far as Linux tells.

use std::fs;
use std::path::Path;

use super::machine::kibibytes;

/// Bytes that this process may use: what the machine has, the control group allows or `ulimit -v` leaves,
/// whichever is least; `None` where the system does not tell.
pub(super) fn there() -> Option<u64> {
    let read = |path: &str| fs::read_to_string(path).unwrap_or_default();
    let status = read("/proc/self/status");
    let taken = kibibytes(&status, "VmSize:").unwrap_or(0);
    let limits = [
        kibibytes(&read("/proc/meminfo"), "MemTotal:"),
        // Addresses that are taken already are none that are left.
        address_space(&read("/proc/self/limits")).map(|limit| limit.saturating_sub(taken)),
        control_group(&read("/proc/self/cgroup"), &read),
    ];
    limits.into_iter().flatten().min()
}

/// The limit that `ulimit -v` sets.
fn address_space(limits: &str) -> Option<u64> {
    let line = limits.lines().find_map(|line| line.strip_prefix("Max address space"))?;
    // `unlimited` is no number.
    line.split_whitespace().next()?.parse().ok()
}

/// The least limit of the control groups that hold this process.
fn control_group(groups: &str, read: &impl Fn(&str) -> String) -> Option<u64> {
    let limits = groups.lines().flat_map(|line| {
        let mut fields = line.splitn(3, ':').skip(1);
        let (controllers, group) = (fields.next().unwrap_or(""), fields.next().unwrap_or(""));
        let (root, file) = match controllers {
            "" => ("/sys/fs/cgroup", "memory.max"),
            c if c.split(',').any(|c| c == "memory") => {
                ("/sys/fs/cgroup/memory", "memory.limit_in_bytes")
            }
            _ => return Vec::new(),
        };
        // A group is bound by those around it. In a container its own is mounted as the root.
        let around = Path::new(group).ancestors().map(|group| {
            let group = group.display().to_string();
            read(&format!("{root}{}/{file}", group.trim_end_matches('/')))
        });
        around.filter_map(|text| text.trim().parse().ok()).collect()
    });
    limits.min()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_read_as_the_kernel_writes_them() {
        assert_eq!(
            kibibytes("A: 1 kB\nMemTotal:       24655 kB\n", "MemTotal:"),
            Some(24655 << 10)
        );
        assert_eq!(kibibytes("", "MemTotal:"), None);
        let limits =
            |soft| format!("Max processes 1 1 processes\nMax address space {soft} 7 bytes\n");
        assert_eq!(address_space(&limits("4096000")), Some(4_096_000));
        assert_eq!(address_space(&limits("unlimited")), None);
        let read = |path: &str| match path {
            "/sys/fs/cgroup/a/b/memory.max" => "max\n".to_owned(),
            "/sys/fs/cgroup/a/memory.max" => "3000\n".to_owned(),
            "/sys/fs/cgroup/memory/c/memory.limit_in_bytes" => "2000\n".to_owned(),
            _ => String::new(),
        };
        assert_eq!(control_group("0::/a/b\n", &read), Some(3000));
        assert_eq!(control_group("0::/a/b\n4:cpu,memory:/c\n", &read), Some(2000));
        assert_eq!(control_group("0::/\n", &read), None);
    }
}
