// The one moment that the 3-D view, the drawings and all plots point to.
const clock = {
  start: 0, end: 0, now: 0, rate: 1, playing: false, listeners: [],

  on(listener) { this.listeners.push(listener); },
  set(time) {
    const next = Math.min(this.end, Math.max(this.start, time));
    if (next === this.now) return;
    this.now = next;
    this.listeners.forEach((listener) => listener());
  },
  play(on) {
    if (this.end <= this.start) return;
    if (on && this.now >= this.end) this.now = this.start;
    this.playing = on;
    this.listeners.forEach((listener) => listener());
    if (on) requestAnimationFrame((first) => this.step(first));
  },
  step(before) {
    requestAnimationFrame((stamp) => {
      if (!this.playing) return;
      this.set(this.now + this.rate * (stamp - before) / 1000);
      if (this.now >= this.end) return this.play(false);
      this.step(stamp);
    });
  },
};
if (main_trajectory) {
  clock.start = main_trajectory.time[0];
  clock.end = main_trajectory.time[main_trajectory.count - 1];
} else if (series.time_s && series.time_s.length > 0) {
  clock.start = series.time_s[0] || 0;
  clock.end = series.time_s[series.time_s.length - 1] || 0;
}
clock.now = clock.end;
