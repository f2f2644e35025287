//! The layout that a recording brings: a first page that tells the story, and one for each question.

use gravcal_robot_model::sweeps::find_sweeps;
use re_sdk::blueprint::components::PanelState;
use re_sdk::blueprint::{
    BarChartView, Blueprint, BlueprintPanel, ContainerLike, Grid, Horizontal, SelectionPanel, Spatial2DView,
    Spatial3DView, StateTimelineView, Tabs, TextDocumentView, TimePanel, TimeSeriesView, Vertical,
};

use crate::contents::CalibrationRecording;
use crate::explanation::Explanation;
use crate::{residuals, series, spectra};

/// The layout for a calibration.
pub fn blueprint(calibration: &CalibrationRecording<'_>) -> Blueprint {
    let pages = [
        Some(overview(calibration)),
        Some(fits(calibration)),
        Some(residuals_page(calibration)),
        spectra_page(calibration),
        solver(calibration),
        identifiability(calibration),
        Some(recording(calibration)),
    ];
    Blueprint::new(Tabs::new(pages.into_iter().flatten()))
        .with_blueprint_panel(BlueprintPanel::from_state(PanelState::Hidden))
        .with_selection_panel(SelectionPanel::from_state(PanelState::Hidden))
        .with_time_panel(TimePanel::new().with_state(PanelState::Collapsed).with_timeline("pose"))
        .with_auto_layout(false)
        .with_auto_views(false)
}

/// Arm, verdict, residuals and a fit.
fn overview(calibration: &CalibrationRecording<'_>) -> ContainerLike {
    let left = Vertical::new([arm(), fit(calibration)]).with_row_shares([0.55, 0.45]);
    let verdict = TextDocumentView::new("Verdict").with_origin("/verdict");
    let right = Vertical::new([verdict.into(), in_std(calibration)]).with_row_shares([0.6, 0.4]);
    Horizontal::new([left.into(), right.into()]).with_column_shares([0.55, 0.45]).with_name("Overview").into()
}

fn arm() -> ContainerLike {
    let contents = ["+ /arm/**", "+ /gravity/**"];
    Spatial3DView::new("Arm and gravity").with_origin("/").with_contents(contents).into()
}

/// The sweep that is shown, where there are sweeps, and the channel that the calibration improves most, before and after.
fn fit(calibration: &CalibrationRecording<'_>) -> ContainerLike {
    let sweep = Spatial2DView::new("Sweep of this pose: readings over angle").with_origin("/sweeps");
    let sweep = (!find_sweeps(calibration.session).is_empty()).then(|| sweep.into());
    let improved = most_improved(calibration).into_iter();
    let improved =
        improved.flat_map(|channel| [before_and_after(calibration, channel), readings(calibration, channel)]);
    Tabs::new(sweep.into_iter().chain(improved).collect::<Vec<ContainerLike>>()).into()
}

/// Residuals of one channel before and after the calibration.
fn before_and_after(calibration: &CalibrationRecording<'_>, channel: usize) -> ContainerLike {
    let session = calibration.session;
    let (name, unit) = (session.channel_name(channel), session.channel_unit(channel));
    let explanations = calibration.explanations();
    let paths = explanations.iter().map(|one| format!("+ {}", residuals::in_unit(one.name, &name)));
    TimeSeriesView::new(format!("{name}: prediction less reading, {unit}"))
        .with_contents(paths.collect::<Vec<_>>())
        .into()
}

/// The channel whose sum of squared residuals in standard deviations falls most.
fn most_improved(calibration: &CalibrationRecording<'_>) -> Option<usize> {
    let deciding = calibration.deciding()?;
    let (before, after) = (Explanation::nominal(deciding)?, Explanation::of(deciding)?);
    let squares = |explanation: &Explanation<'_>, channel: usize| {
        explanation.of_channel(channel).map(|one| (one.residual / one.std).powi(2)).sum::<f64>()
    };
    let fall = |channel: &usize| squares(&before, *channel) - squares(&after, *channel);
    calibration.channels().into_iter().max_by(|a, b| fall(a).total_cmp(&fall(b)))
}

fn readings(calibration: &CalibrationRecording<'_>, channel: usize) -> ContainerLike {
    let session = calibration.session;
    let (name, unit) = (session.channel_name(channel), session.channel_unit(channel));
    TimeSeriesView::new(format!("{name}: readings over poses, {unit}")).with_origin(series::folder(&name)).into()
}

/// Residuals of all channels of the deciding estimator.
fn in_std(calibration: &CalibrationRecording<'_>) -> ContainerLike {
    let name = calibration.deciding().map_or("joint", |result| result.name.as_str());
    let view = TimeSeriesView::new(format!("Residuals, {name}, in standard deviations"));
    view.with_origin(residuals::in_std(name)).into()
}

/// Readings and predictions, channel by channel.
fn fits(calibration: &CalibrationRecording<'_>) -> ContainerLike {
    let views = calibration.channels().into_iter().map(|channel| readings(calibration, channel));
    Grid::new(views).with_name("Fits").into()
}

/// Residuals in the unit of the reading by channel, and in standard deviations by estimator.
fn residuals_page(calibration: &CalibrationRecording<'_>) -> ContainerLike {
    let by_channel = calibration.channels().into_iter().map(|channel| before_and_after(calibration, channel));
    let explanations = calibration.explanations();
    let by_explanation = explanations.iter().map(|explanation| {
        let view = TimeSeriesView::new(format!("{}, in standard deviations", explanation.name));
        view.with_origin(residuals::in_std(explanation.name)).into()
    });
    Grid::new(by_channel.chain(by_explanation).collect::<Vec<ContainerLike>>()).with_name("Residuals").into()
}

/// Spectra of the residuals of an arm in motion, channel by channel; nothing of poses.
fn spectra_page(calibration: &CalibrationRecording<'_>) -> Option<ContainerLike> {
    let session = calibration.session;
    let views = spectra::of_channels(calibration).into_iter().map(|(channel, of_channel)| {
        let (name, unit) = (session.channel_name(channel), session.channel_unit(channel));
        let title = format!(
            "{name}: amplitude of residuals, {unit}, over frequency, Hz (windows let little pass beyond {:.1} Hz)",
            of_channel.cut_off
        );
        BarChartView::new(title).with_origin(spectra::path(&name)).into()
    });
    let views: Vec<ContainerLike> = views.collect();
    (!views.is_empty()).then(|| Grid::new(views).with_name("Spectra").into())
}

/// The solver's way; nothing where none was kept.
fn solver(calibration: &CalibrationRecording<'_>) -> Option<ContainerLike> {
    let solved = calibration.results.iter().filter(|result| !result.trace.is_empty());
    let views = solved.flat_map(|result| {
        let name = &result.name;
        let trace = TimeSeriesView::new(format!("{name}: cost, step, damping, log₁₀ (timeline: iteration)"))
            .with_origin(re_sdk::entity_path!["trace", name]);
        let mut quantities: Vec<&str> =
            result.parameters.iter().filter_map(|p| Some(p.name.rsplit_once('.')?.1)).collect();
        quantities.sort_unstable();
        quantities.dedup();
        let parameters = quantities.into_iter().map(move |quantity| {
            let view = TimeSeriesView::new(format!("{name}: {quantity} (timeline: iteration)"));
            view.with_origin(re_sdk::entity_path!["parameters", name, quantity]).into()
        });
        [trace.into()].into_iter().chain(parameters)
    });
    let views: Vec<ContainerLike> = views.collect();
    (!views.is_empty()).then(|| Grid::new(views).with_name("Solver").into())
}

/// Singular values and combinations of each estimator.
fn identifiability(calibration: &CalibrationRecording<'_>) -> Option<ContainerLike> {
    let views = calibration.results.iter().flat_map(|result| {
        let path = |what| re_sdk::entity_path!["identifiability", result.name, what];
        let bars = BarChartView::new(format!("{}: singular values, log₁₀", result.name));
        let text = TextDocumentView::new(format!("{}: combinations", result.name));
        [text.with_origin(path("combinations")).into(), bars.with_origin(path("singular_values")).into()]
    });
    let views: Vec<ContainerLike> = views.collect();
    (!views.is_empty()).then(|| Grid::new(views).with_name("Identifiability").into())
}

/// Which poses stand where, with which load, and when the arm stood still.
fn recording(calibration: &CalibrationRecording<'_>) -> ContainerLike {
    let poses = StateTimelineView::new("Poses: table and load").with_origin("/poses");
    let contents = ["+ /standstills/**", "+ /slow_sweeps/**"];
    let still = StateTimelineView::new("Standstills and slow sweeps (timeline: time)").with_contents(contents);
    let still = (!calibration.session.searched.is_empty()).then(|| still.into());
    Vertical::new([poses.into()].into_iter().chain(still).collect::<Vec<ContainerLike>>()).with_name("Recording").into()
}
