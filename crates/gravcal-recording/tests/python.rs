//! Bags written here are opened by what ROS users have in Python: `mcap-ros2-support` and `rosbags`. The Python is `GRAVCAL_PYTHON`, else
//! `python3`; where it has not these packages the test says so (`pip install mcap-ros2-support rosbags`).

use std::collections::BTreeMap;
use std::process::Command;

use gravcal_recording::{Heading, create};

/// Prints topic, stamp, names, positions, velocities and efforts of every message, as each package reads them.
const SCRIPT: &str = r#"
import sys
from pathlib import Path
from mcap.reader import make_reader
from mcap_ros2.reader import read_ros2_messages
from rosbags.rosbag2.storage_mcap import McapReader
from rosbags.typesys import Stores, get_typestore

def show(topic, m):
    print(topic, m.header.stamp.sec, m.header.stamp.nanosec, list(m.name),
          *([float(x) for x in numbers] for numbers in (m.position, m.velocity, m.effort)))

path = sys.argv[1]
for m in read_ros2_messages(path):
    show(m.channel.topic, m.ros_msg)
store = get_typestore(Stores.ROS2_HUMBLE)
bag = McapReader(Path(path))
bag.open()
for c, t, data in bag.messages(list(bag.connections)):
    show(c.topic, store.deserialize_cdr(data, c.msgtype))
with open(path, 'rb') as file:
    print([(m.name, m.metadata) for m in make_reader(file).iter_metadata()])
"#;

fn python() -> Option<Command> {
    let program = std::env::var_os("GRAVCAL_PYTHON").unwrap_or_else(|| "python3".into());
    let found = Command::new(&program).args(["-c", "import mcap_ros2, rosbags"]).output();
    if !found.is_ok_and(|output| output.status.success()) {
        eprintln!(
            "SKIPPED: {} has no mcap-ros2-support and rosbags; GRAVCAL_PYTHON names one that has",
            program.display()
        );
        return None;
    }
    Some(Command::new(program))
}

#[test]
fn a_bag_opens_in_python() {
    let Some(mut python) = python() else { return };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bag.mcap");
    let columns = ["time_s", "a.position", "b.position", "a.effort", "b.effort", "/hand:c.velocity"];
    let heading = Heading {
        columns: columns.map(str::to_owned).to_vec(),
        metadata: BTreeMap::from([("load".to_owned(), "plate-a".to_owned())]),
    };
    let mut writer = create(&path, &heading, false).unwrap();
    writer.write(&[1.25, 0.5, -0.5, 3.0, f64::NAN, f64::NAN]).unwrap();
    writer.write(&[2.0, f64::NAN, f64::NAN, f64::NAN, f64::NAN, 0.125]).unwrap();
    writer.finish().unwrap();

    let output = python.args(["-c", SCRIPT]).arg(&path).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let messages = "/joint_states 1 250000000 ['a', 'b'] [0.5, -0.5] [] [3.0, nan]\n/hand 2 0 ['c'] [] [0.125] []\n";
    let expected = format!("{messages}{messages}[('gravcal', {{'load': 'plate-a'}})]\n");
    assert_eq!(String::from_utf8_lossy(&output.stdout), expected);
}
