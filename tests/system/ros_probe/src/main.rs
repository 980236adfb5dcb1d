//! A ROS 2 node of an independent implementation of rmw_zenoh's format.
//! ros-probe ENDPOINT read SECONDS | drive VX SECONDS | describe
use std::env::args;
use std::num::NonZeroUsize;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use hiroz::qos::{QosDurability, QosHistory, QosProfile};
use hiroz::{context::ZContextBuilder, Builder, Result};
use hiroz_msgs::geometry_msgs::{Twist, Vector3};
use hiroz_msgs::sensor_msgs::{Imu, JointState};
use hiroz_msgs::std_msgs::String as Text;

fn now() -> i128 {
    SystemTime::now().duration_since(UNIX_EPOCH).unwrap().as_nanos() as i128
}

fn main() -> Result<()> {
    let words: Vec<String> = args().collect();
    let ctx = ZContextBuilder::default()
        .with_mode("client")
        .with_connect_endpoints([words[1].as_str()])
        .disable_multicast_scouting()
        .build()?;
    let node = ctx.create_node("probe").build()?;
    match words[2].as_str() {
        "read" => {
            let seconds: f64 = words[3].parse().unwrap();
            let sub = node.create_sub::<JointState>("joint_states").build()?;
            let imu = node.create_sub::<Imu>("imu").build()?;
            let first = sub.recv_timeout(Duration::from_secs(20))?;
            let began = Instant::now();
            let mut late: Vec<i128> = vec![];
            while began.elapsed().as_secs_f64() < seconds {
                let m = sub.recv_timeout(Duration::from_secs(2))?;
                let stamp = m.header.stamp.sec as i128 * 1_000_000_000 + m.header.stamp.nanosec as i128;
                late.push(now() - stamp);
            }
            let rate = late.len() as f64 / began.elapsed().as_secs_f64();
            late.sort();
            let at = |q: f64| late[((late.len() - 1) as f64 * q) as usize] as f64 / 1e6;
            let z = imu.recv_timeout(Duration::from_secs(2))?.linear_acceleration.z;
            println!(
                "{{\"rate\": {:.2}, \"n\": {}, \"joints\": {}, \"first\": {:?}, \"p50_ms\": {:.3}, \"p99_ms\": {:.3}, \"gravity\": {:.2}}}",
                rate, late.len(), first.name.len(), first.name[0], at(0.5), at(0.99), z
            );
        }
        "drive" => {
            let vx: f64 = words[3].parse().unwrap();
            let seconds: f64 = words[4].parse().unwrap();
            let publisher = node.create_pub::<Twist>("cmd_vel").build()?;
            let began = Instant::now();
            while began.elapsed().as_secs_f64() < seconds {
                let zero = || Vector3 { x: 0.0, y: 0.0, z: 0.0 };
                publisher.publish(&Twist { linear: Vector3 { x: vx, ..zero() }, angular: zero() })?;
                std::thread::sleep(Duration::from_millis(100));
            }
            std::process::exit(0); // without a last zero: the connection is lost
        }
        _ => {
            let qos = QosProfile {
                durability: QosDurability::TransientLocal,
                history: QosHistory::KeepLast(NonZeroUsize::new(1).unwrap()),
                ..Default::default()
            };
            let sub = node.create_sub::<Text>("robot_description").with_qos(qos).build()?;
            let text = sub.recv_timeout(Duration::from_secs(10))?.data;
            println!("{{\"characters\": {}, \"start\": {:?}}}", text.len(), &text[..40]);
        }
    }
    Ok(())
}
