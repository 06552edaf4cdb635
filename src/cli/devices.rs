//! `shutterlab devices`: what this machine and this build offer.

use super::say;
use crate::pipelines::{DeviceChoice, OpenDevice};
use shutterlab_stimuli::stimulus::Method;

/// Show what can render on this machine.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Print it as JSON
    #[arg(long)]
    json: bool,
}

pub(super) fn run(args: &Args) -> anyhow::Result<()> {
    let opened = [
        ("gpu", OpenDevice::open(DeviceChoice::Gpu)),
        ("cpu", OpenDevice::open(DeviceChoice::Cpu)),
    ];
    let methods = Method::ALL.map(|(name, _)| name);
    let rows = opened.map(|(choice, device)| match device {
        Ok(device) => (choice, device.describe(), None),
        Err(error) => (choice, Default::default(), Some(error.to_string())),
    });
    if args.json {
        let list = rows.map(|(choice, device, error)| {
            serde_json::json!({
                "device": choice,
                "adapter": error.is_none().then_some(device.adapter),
                "driver": error.is_none().then_some(device.driver),
                "error": error,
                "methods": methods,
            })
        });
        return say(&format!("{:#}", serde_json::Value::from(list.to_vec())));
    }
    for (choice, device, error) in rows {
        match error {
            None => say(format!("{choice}: {} {}", device.adapter, device.driver).trim_end())?,
            Some(error) => say(&format!("{choice}: {error}"))?,
        }
    }
    say(&format!("methods: {}", methods.join(", ")))
}
