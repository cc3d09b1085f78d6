// Robots beside each other that move by one cursor and are seen by one camera: all of the plane, and all of space.

const DIMENSIONS = [true, false];  // flat, or not
const LEGIBLE = 240;  // units that a drawing is wide at least: in a narrower one the names are smaller
let player;
(async () => {
  const compared = await unpacked("COMPARISON"), t = await numbers("TIMES", Float64Array), columns = curvesOf(await numbers("VALUES", Float32Array), t.length);
  const positions = await Promise.all(compared.robots.map(async ({positions: pack, nq}) => positionsOf(await numbers(pack, Float64Array, nq), nq)));
  moves();
  const robots = [], cameras = new Map(DIMENSIONS.map((flat) => {
    const found = compared.robots.find(({scene}) => scene.flat === flat);
    return [flat, found && new Camera(found.scene)];
  }));
  const of = (flat) => robots.filter(({data: {scene}}) => scene.flat === flat), corners = {true: [], false: []};
  compared.robots.forEach((robot, k) => {
    const {flat} = robot.scene, options = {least: LEGIBLE, camera: cameras.get(flat), turned: () => { for (const {stage} of of(flat)) stage.draw(); }};
    robots.push(new MovingRobot(robot, find(`canvas-${k}`), find(`names-${k}`), kernels[robot.kernel], positions[k], columns, options));
    corners[flat].push(...cameras.get(flat).corners);
  });
  for (const flat of DIMENSIONS) if (cameras.get(flat)) cameras.get(flat).corners = corners[flat];  // one scale, one window on the world
  player = new Cursor(robots, t, compared, columns);
})();
