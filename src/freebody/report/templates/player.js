// The motion of a study: its robot, and what the page computes itself.

class Player extends Cursor {
  constructor(study, t, q, columns) {
    const robot = new MovingRobot(study, find("canvas"), find("names"), placed, q, columns);
    super([robot], t, study, columns);
    Object.assign(this, {study, robot, q, stage: robot.stage});
  }
}

let player;
(async () => {
  const study = await unpacked("STUDY"), t = await numbers("TIMES", Float64Array), q = positionsOf(await numbers("POSITIONS", Float64Array, study.nq), study.nq);
  const columns = curvesOf(await numbers("VALUES", Float32Array), t.length);
  moves();
  player = new Player(study, t, q, columns);
  if (study.what) player.what = new WhatIf(player, study, await numbers("RATES", Float64Array, study.nv), await numbers("EXPECTED", Float64Array, study.nv));
})();
