//! Curves over time of a page.

use dcb_formats::results::{Channel, Results};
use dcb_runtime::error::Error;
use dcb_view::{Array, Arrays, History, HistoryColumn};

use super::spread;

/// Numbers of all curves of a page, about.
const NUMBERS: usize = 200_000;
/// Points of a curve, at most and at least.
const MOST_POINTS: usize = 2000;
const FEWEST_POINTS: usize = 150;

/// All channels but the motion of bodies, the scene's outputs first; those of one unit together.
pub fn of(results: &Results, time: &[f64], arrays: &mut Arrays) -> Result<Vec<History>, Error> {
    let mut channels: Vec<&Channel> = results
        .channels()
        .iter()
        .filter(|channel| !channel.path.starts_with("motion/"))
        .collect();
    channels.sort_by_key(|channel| !channel.path.starts_with("outputs/"));
    let curves: usize = channels.iter().map(|channel| channel.columns.len()).sum();
    let most = (NUMBERS / curves.max(1)).clamp(FEWEST_POINTS, MOST_POINTS);
    let rows = spread(time.len(), most);
    let times = arrays.reals(rows.iter().map(|row| time[*row]));
    let mut histories = Vec::new();
    for channel in channels {
        let values = results.history(&channel.path)?;
        let mut of_channel: Vec<History> = Vec::new();
        for (column, described) in channel.columns.iter().enumerate() {
            let values = arrays.reals(rows.iter().map(|row| values[(*row, column)]));
            let curve = HistoryColumn {
                name: described.name.clone(),
                values,
            };
            match of_channel
                .iter_mut()
                .find(|known| known.unit == described.unit)
            {
                Some(known) => known.columns.push(curve),
                None => of_channel.push(history(channel, &described.unit, curve, times)),
            }
        }
        histories.extend(of_channel);
    }
    Ok(histories)
}

fn history(channel: &Channel, unit: &str, curve: HistoryColumn, times: Array) -> History {
    let (group, title) = match channel.path.split_once('/') {
        Some(("outputs", name)) => ("outputs", name.to_owned()),
        Some((group, name)) => (group, format!("{name} ({})", group.replace('_', " "))),
        None => ("", channel.path.clone()),
    };
    History {
        name: channel.path.clone(),
        title,
        quantity: group.replace('_', " "),
        unit: unit.to_owned(),
        columns: vec![curve],
        times: Some(times),
    }
}
