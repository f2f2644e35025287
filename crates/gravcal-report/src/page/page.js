// The figures of a calibration; what the data are, figures.rs tells.
(() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const floats = (text) => {
    const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
    return new Float32Array(bytes.buffer);
  };
  const element = (id) => document.getElementById(id);
  if (!element("fit")) return;

  const poses = { table: floats(data.poses.table), line: floats(data.poses.line), time: data.poses.time && floats(data.poses.time) };
  const joints = data.joints.map((joint) => ({ ...joint, positions: floats(joint.positions) }));
  const channels = data.channels.map((channel) => ({ ...channel, readings: floats(channel.readings) }));
  const estimators = data.estimators.map((estimator) => ({
    name: estimator.name,
    channels: estimator.channels.map((one) => ({
      after: floats(one.after), before: one.before && floats(one.before),
      stds: one.stds && floats(one.stds), std: one.std, weights: one.weights && floats(one.weights),
      parts: one.parts && { gravity: floats(one.parts.gravity), inertia: floats(one.parts.inertia), bias: floats(one.parts.bias) },
      spectra: one.spectra && {
        frequency: floats(one.spectra.frequency), reading: floats(one.spectra.reading),
        residual: floats(one.spectra.residual), cutOff: one.spectra.cut_off,
      },
    })),
  }));
  const std = (one, pose) => (one.stds ? one.stds[pose] : one.std);
  const number = (value) => Number(value.toPrecision(7)).toString();
  const where = (pose) => `${data.tables[poses.table[pose]]}:${poses.line[pose]}`;
  const stance = (pose) => joints.map((joint) => `${joint.name} ${joint.unit === "deg" ? joint.positions[pose].toFixed(1) : number(joint.positions[pose])} ${joint.unit}`).join(", ");
  const options = (select, texts) => texts.forEach((text, value) => select.add(new Option(text, value)));
  // Of what the channel's own joint reads; an axis of an instrument has none.
  const own = (channel) => joints[channel.index] || null;

  function tellPose(place, channel, one, pose) {
    const reading = channel.readings[pose], residual = one.after[pose];
    place.textContent = `${where(pose)} ${channel.name}: reads ${number(reading)} ${channel.unit}, predicted ${number(reading + residual)}`
      + ` (${(residual / std(one, pose)).toFixed(1)} std); ${stance(pose)}`;
  }

  // Fit.
  const fit = new Figure(element("fit"), (near) => tellPose(element("fit-hover"), channels[picked("fit-channel")], estimators[0].channels[picked("fit-channel")], near.pose));
  const picked = (id) => Number(element(id).value);
  options(element("fit-channel"), channels.map((channel) => channel.name));
  options(element("fit-sweep"), data.sweeps.map((sweep) => sweep.told).concat(["all: prediction over reading"]));

  function drawFit() {
    const place = picked("fit-channel"), channel = channels[place], sweep = data.sweeps[picked("fit-sweep")];
    const [main, other] = estimators.map((estimator) => estimator.channels[place]);
    const range = sweep ? Array.from({ length: sweep.count }, (_, i) => sweep.first + i) : channel.readings.map((_, i) => i);
    const used = Array.from(range).filter((pose) => Number.isFinite(main.after[pose]));
    if (!sweep) {
      const readings = used.map((pose) => channel.readings[pose]);
      const predicted = (kind) => used.map((pose) => channel.readings[pose] + main[kind][pose]);
      const [low, high] = extent([{ y: readings }], "y");
      element("fit-legend").textContent = `Blue: ${estimators[0].name}. Orange: sensors at nominal values. A perfect fit lies on the line.`;
      fit.show({
        xLabel: `reading, ${channel.unit}`, yLabel: `prediction, ${channel.unit}`,
        series: [
          { kind: "points", x: readings, y: predicted("before"), colour: "before" },
          { kind: "line", x: [low, high], y: [low, high], colour: "soft", width: 1 },
          { kind: "points", x: readings, y: predicted("after"), colour: "after", poses: used },
        ],
      });
      return;
    }
    const joint = joints[sweep.swept];
    used.sort((a, b) => joint.positions[a] - joint.positions[b]);
    const x = used.map((pose) => joint.positions[pose]);
    const predicted = (one, kind) => used.map((pose) => channel.readings[pose] + one[kind][pose]);
    const series = [
      { kind: "line", x, y: predicted(main, "before"), colour: "before", dashed: true },
      { kind: "line", x, y: predicted(main, "after"), colour: "after" },
      { kind: "points", x, y: used.map((pose) => channel.readings[pose]), colour: "text", poses: used },
    ];
    if (other) series.splice(1, 0, { kind: "line", x, y: predicted(other, "after"), colour: "other", dashed: true, width: 1.2 });
    fit.show({ xLabel: `${joint.name} reads, ${joint.unit}`, yLabel: `${channel.name} reads, ${channel.unit}`, series });
    element("fit-legend").textContent = `Points: readings. Line: ${estimators[0].name}. Dashed: sensors at nominal values.${other ? ` Thin, dashed: ${estimators[1].name}.` : ""}`;
  }
  // The reading that changes most, in a sweep of its own joint if there are any.
  function mostTelling() {
    let best = [0, data.sweeps.length], most = 0;
    channels.forEach((channel, place) => {
      if (data.sweeps.length) return;
      const [low, high] = extent([{ y: channel.readings }], "y"), change = (high - low) / std(estimators[0].channels[place], 0);
      if (change > most) { most = change; best = [place, 0]; }
    });
    data.sweeps.forEach((sweep, index) => channels.forEach((channel, place) => {
      if (channel.index !== sweep.swept) return;
      let low = Infinity, high = -Infinity;
      for (let i = sweep.first; i < sweep.first + sweep.count; i++) {
        const value = channel.readings[i];
        if (Number.isFinite(estimators[0].channels[place].after[i])) { low = Math.min(low, value); high = Math.max(high, value); }
      }
      const change = (high - low) / std(estimators[0].channels[place], sweep.first);
      if (change > most) { most = change; best = [place, index]; }
    }));
    return best;
  }
  const [firstChannel, firstSweep] = mostTelling();
  element("fit-channel").value = firstChannel;
  element("fit-sweep").value = firstSweep;
  element("fit-channel").addEventListener("change", drawFit);
  element("fit-sweep").addEventListener("change", drawFit);

  // Of what predictions are made, where an arm moved.
  function torqueOverTime() {
    const moving = channels.map((_, place) => place).filter((place) => estimators[0].channels[place].parts);
    const tables = data.tables.map((_, table) => table).filter((table) => moving.some((place) =>
      estimators[0].channels[place].parts.gravity.some((value, pose) => Number.isFinite(value) && poses.table[pose] === table)));
    moving.forEach((place) => element("parts-channel").add(new Option(channels[place].name, place)));
    tables.forEach((table) => element("parts-table").add(new Option(data.tables[table], table)));
    const figure = new Figure(element("parts"), (near) => {
      const place = picked("parts-channel");
      tellPose(element("parts-hover"), channels[place], estimators[0].channels[place], near.pose);
    });
    const draw = () => {
      const channel = channels[picked("parts-channel")], one = estimators[0].channels[picked("parts-channel")], { parts } = one;
      const used = Array.from(channel.readings, (_, pose) => pose)
        .filter((pose) => Number.isFinite(parts.gravity[pose]) && poses.table[pose] === picked("parts-table"));
      const x = used.map((pose) => (poses.time ? poses.time[pose] : pose + 1));
      const predicted = (pose) => channel.readings[pose] + one.after[pose] - parts.bias[pose];
      const line = (of, name, more) => ({ kind: "line", x, y: used.map(of), colour: name, ...more });
      figure.show({
        xLabel: poses.time ? "time, s" : "window", yLabel: `${channel.name}, ${channel.unit}`,
        series: [
          line((pose) => parts.gravity[pose], "good", { width: 1.4 }),
          line((pose) => parts.inertia[pose], "before", { width: 1.4 }),
          line((pose) => predicted(pose) - parts.gravity[pose] - parts.inertia[pose], "other", { width: 1.4 }),
          line(predicted, "after"),
          { kind: "points", x, y: used.map((pose) => channel.readings[pose] - parts.bias[pose]), colour: "text", poses: used, size: 3 },
        ],
      });
      element("parts-legend").textContent = "Points: readings less the bias. Blue: all of the model. Green: gravity. Orange: inertia. Violet: friction and the rest.";
    };
    element("parts-channel").addEventListener("change", draw);
    element("parts-table").addEventListener("change", draw);
    draw();
  }

  // Residuals, and whether they are noise: a panel for each reading.
  function panels(place, count, hover) {
    let pair;
    return Array.from({ length: count }, (_, index) => {
      const canvas = document.createElement("canvas");
      canvas.dataset.height = 200;
      if (hover) {
        element(place).append(canvas);
      } else {
        if (index % 2 === 0) { pair = document.createElement("div"); pair.className = "pair"; element(place).append(pair); }
        pair.append(canvas);
      }
      return new Figure(canvas, hover && ((near) => hover(index, near)));
    });
  }
  // How residuals are spread over frequency, where an arm moved.
  function spectra() {
    const moving = channels.filter((_, place) => estimators[0].channels[place].spectra);
    const figures = panels("spectra", moving.length, (index, near) => {
      const channel = moving[index], { frequency, reading, residual } = estimators[0].channels[channels.indexOf(channel)].spectra, unit = `${channel.unit}/√Hz`;
      element("spectrum-hover").textContent = `${channel.name} at ${number(frequency[near.pose])} Hz: readings `
        + `${reading[near.pose].toPrecision(3)} ${unit}, residuals ${residual[near.pose].toPrecision(3)} ${unit}`;
    });
    moving.forEach((channel, index) => {
      const { frequency, reading, residual, cutOff } = estimators[0].channels[channels.indexOf(channel)].spectra;
      const logarithms = (values) => Array.from(values, (value) => (value > 0 ? Math.log10(value) : NaN));
      const x = logarithms(frequency), series = [
        { kind: "line", x, y: logarithms(reading), colour: "soft" },
        { kind: "line", x, y: logarithms(residual), colour: "after", poses: x.map((_, place) => place) },
      ];
      const yRange = extent(series, "y"), end = Math.log10(cutOff);
      figures[index].show({
        title: channel.name, xLabel: "frequency, Hz", yLabel: `${channel.unit}/√Hz`, logarithms: true, yRange,
        series: [{ kind: "line", x: [end, end], y: yRange, colour: "before", dashed: true, width: 1.2 }, ...series],
      });
    });
  }

  const chosen = () => estimators[picked("estimator")];
  const residualPanels = panels("residuals", channels.length, (index, near) =>
    tellPose(element("residual-hover"), channels[index], chosen().channels[index], near.pose));
  const normalPanels = panels("normality", 2 * channels.length);
  options(element("estimator"), estimators.map((estimator) => estimator.name));
  options(element("against"), ["angle of the joint", "number of the pose"].concat(poses.time ? ["time"] : []));

  function standardised(index) {
    const one = chosen().channels[index], at = [], z = [];
    for (let pose = 0; pose < data.poses.count; pose++) {
      if (Number.isFinite(one.after[pose])) { at.push(pose); z.push(one.after[pose] / std(one, pose)); }
    }
    return { at, z, one };
  }
  function quantile(p) {
    // Acklam's rational approximation of the normal quantile, good to 1e-9 relative.
    const a = [-39.69683028665376, 220.9460984245205, -275.9285104469687, 138.357751867269, -30.66479806614716, 2.506628277459239];
    const b = [-54.47609879822406, 161.5858368580409, -155.6989798598866, 66.80131188771972, -13.28068155288572];
    const c = [-0.007784894002430293, -0.3223964580411365, -2.400758277161838, -2.549732539343734, 4.374664141464968, 2.938163982698783];
    const d = [0.007784695709041462, 0.3224671290700398, 2.445134137142996, 3.754408661907416];
    const horner = (k, x) => k.reduce((sum, one) => sum * x + one, 0);
    if (p < 0.02425) { const q = Math.sqrt(-2 * Math.log(p)); return horner(c, q) / (horner(d, q) * q + 1); }
    if (p > 1 - 0.02425) return -quantile(1 - p);
    const q = p - 0.5, r = q * q;
    return horner(a, r) * q / (horner(b, r) * r + 1);
  }
  function autocorrelation(z, at) {
    const mean = z.reduce((sum, one) => sum + one, 0) / z.length, lags = Math.min(30, Math.floor(z.length / 3));
    // Poses of different files are no neighbours.
    const pair = (i, lag) => (poses.table[at[i]] === poses.table[at[i - lag]] ? (z[i] - mean) * (z[i - lag] - mean) : 0);
    const product = (lag) => { let sum = 0; for (let i = lag; i < z.length; i++) sum += pair(i, lag); return sum; };
    const whole = product(0) || 1;
    return Array.from({ length: lags }, (_, lag) => product(lag + 1) / whole);
  }
  function drawResiduals() {
    channels.forEach((channel, index) => {
      const { at, z, one } = standardised(index), joint = own(channel), against = picked("against");
      const position = against === 0 && joint;
      const x = at.map((pose) => (position ? joint.positions[pose] : against === 2 ? poses.time[pose] : pose + 1));
      const far = z.map((_, i) => i).filter((i) => Math.abs(z[i]) > 3.5 || (one.weights && one.weights[at[i]] < 0.5));
      // Where a fifth of all is far off, none stands out.
      const marked = far.length < 0.2 * z.length, rings = marked ? far : [];
      const unmarked = marked ? "" : `; ${Math.round((100 * far.length) / z.length)} % far off`;
      const label = position ? `${joint.name} reads, ${joint.unit}` : against === 2 ? "time, s" : "pose";
      const rms = Math.sqrt(z.reduce((sum, r) => sum + r * r, 0) / Math.max(1, z.length));
      residualPanels[index].show({
        title: `${channel.name}: rms ${rms.toFixed(2)} std of ${one.stds ? "each reading" : `${number(one.std || 0)} ${channel.unit}`}${unmarked}`, xLabel: label,
        bands: [[-2, 2]], series: [{ kind: "points", x, y: z, colour: "after", poses: at, rings }],
      });
      const sorted = Float64Array.from(z).sort();
      const normal = Array.from(sorted, (_, k) => quantile((k + 0.5) / sorted.length));
      const end = Math.max(3, -(normal[0] || 0));
      normalPanels[2 * index].show({
        title: `${channel.name}: normal quantiles`, xLabel: "expected, std",
        series: [
          { kind: "line", x: [-end, end], y: [-end, end], colour: "soft", width: 1 },
          { kind: "points", x: normal, y: Array.from(sorted), colour: "after", size: 3 },
        ],
      });
      const alike = autocorrelation(z, at), band = 1.96 / Math.sqrt(Math.max(1, z.length));
      normalPanels[2 * index + 1].show({
        title: `${channel.name}: autocorrelation`, xLabel: "poses apart", xRange: [0, Math.max(2, alike.length + 1)],
        yRange: [Math.min(-0.3, ...alike) - 0.05, Math.max(0.5, ...alike) + 0.05], bands: [[-band, band]],
        series: alike.map((one, lag) => ({ kind: "line", x: [lag + 1, lag + 1], y: [0, one], colour: "after", width: 3 })),
      });
    });
  }
  element("estimator").addEventListener("change", drawResiduals);
  element("against").addEventListener("change", drawResiduals);

  // Correlations.
  function drawCorrelation() {
    const { names } = data.correlation, matrix = floats(data.correlation.matrix), count = names.length;
    if (!count) return;
    const layout = (width, height) => {
      const left = Math.min(190, width * 0.4), top = 8;
      const cell = Math.max(3, Math.min((width - left - 8) / count, (height - top - 8) / count));
      return { left, top, cell };
    };
    const canvas = element("correlation");
    canvas.dataset.height = Math.min(720, Math.max(180, 16 * count + 16));
    let at = null;
    const figure = new Figure(canvas, (text) => { element("correlation-hover").textContent = text; });
    figure.show({
      paint: (c, width, height) => {
        const { left, top, cell } = at = layout(width, height);
        c.textAlign = "right"; c.textBaseline = "middle";
        const each = Math.max(1, Math.ceil(11 / cell));
        for (let i = 0; i < count; i++) {
          c.fillStyle = colour("text");
          if (i % each === 0) c.fillText(names[i], left - 6, top + (i + 0.5) * cell, left - 8);
          for (let j = 0; j < count; j++) {
            const r = matrix[i * count + j];
            c.globalAlpha = Math.min(1, Math.abs(r)); c.fillStyle = colour(r > 0 ? "after" : "before");
            c.fillRect(left + j * cell, top + i * cell, cell - 0.5, cell - 0.5);
            c.globalAlpha = 1;
          }
        }
        c.strokeStyle = colour("line"); c.strokeRect(left, top, count * cell, count * cell);
      },
      at: (x, y) => {
        const i = Math.floor((y - at.top) / at.cell), j = Math.floor((x - at.left) / at.cell);
        if (i < 0 || j < 0 || i >= count || j >= count) return "";
        return `${names[i]} and ${names[j]}: ${matrix[i * count + j].toFixed(3)}`;
      },
    });
  }

  drawFit();
  if (element("parts")) torqueOverTime();
  drawResiduals();
  if (element("spectra")) spectra();
  if (element("correlation")) drawCorrelation();
})();
