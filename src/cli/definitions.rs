//! What the numbers are that `compare` and `measure` show, for their help.

/// The metrics; `measure::metrics` and `measure::flip` say the same with their sources.
pub(super) const METRICS: &str = "\
Metrics, of a picture I and a reference R in linear sRGB; means are over pixels and their three channels:
  MSE       mean((I - R)^2); RMSE is its root
  relMSE    mean((I - R)^2 / (R^2 + 0.01))
  trimmed   relMSE without the worst 0.1 %: without the floor(N/1000) of N pixels whose own error e,
            their mean of (I - R)^2 / (R^2 + 0.01) over three channels, is largest
  99.9 %    of the pixels' errors e the smallest that 99.9 % of them do not exceed; largest: the largest
  SMAPE     mean(|I - R| / (|I| + |R| + 0.01))
  FLIP      mean over pixels of LDR-FLIP (Andersson et al. 2020) at 67 pixels per degree, of colours
            clamped to [0, 1]
  bias      mean(I - R)
Pixels with a number that is not finite, in either picture, are left out and counted; for FLIP they are as \
the reference. A reference with the layers of `render --variance` has a known variance v of its means: its \
own noise adds mean(v) to the MSE and mean(v / (R^2 + 0.01)) to the relMSE, which is subtracted where it \
says so.";
