/// The slope of a column over another, and the part of its variance that this line leaves.
pub(super) fn line(of: &[f64], over: &[f64]) -> (f64, f64) {
    let count = of.len().max(1) as f64;
    let mean = |values: &[f64]| values.iter().sum::<f64>() / count;
    let (m, n) = (mean(of), mean(over));
    let [mut xx, mut xy, mut yy] = [0.0; 3];
    for (y, x) in of.iter().zip(over) {
        xx += (x - n) * (x - n);
        xy += (x - n) * (y - m);
        yy += (y - m) * (y - m);
    }
    (xy / xx, 1.0 - xy * xy / (xx * yy))
}
