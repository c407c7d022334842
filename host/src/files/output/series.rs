//! A time series of bodies for `ParaView`: a collection file that names one file per tick.

use std::collections::BTreeSet;
use std::fmt::Write as _;

/// Name of the collection.
pub const SERIES: &str = "series.pvd";

/// Returns the name of the file of a tick.
#[must_use]
pub fn state_name(tick: u64) -> String {
    format!("state_{tick}.vtu")
}

/// Returns the collection of the files of these ticks; times are in seconds, of ticks at a rate \[Hz\].
#[must_use]
pub fn pvd(ticks: &BTreeSet<u64>, hz: u32) -> String {
    let mut text = String::from(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" \
         byte_order=\"LittleEndian\">\n<Collection>\n",
    );
    for &tick in ticks {
        let (time_s, file) = (tick as f64 / f64::from(hz), state_name(tick));
        let _ = writeln!(text, "<DataSet timestep=\"{time_s}\" part=\"0\" file=\"{file}\"/>");
    }
    text.push_str("</Collection>\n</VTKFile>\n");
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_stand_in_the_order_of_time() {
        let text = pvd(&BTreeSet::from([1200, 7, 90]), 2000);
        let rows: Vec<&str> = text.lines().filter(|row| row.starts_with("<DataSet")).collect();
        assert_eq!(
            rows,
            [
                "<DataSet timestep=\"0.0035\" part=\"0\" file=\"state_7.vtu\"/>",
                "<DataSet timestep=\"0.045\" part=\"0\" file=\"state_90.vtu\"/>",
                "<DataSet timestep=\"0.6\" part=\"0\" file=\"state_1200.vtu\"/>",
            ]
        );
    }
}
