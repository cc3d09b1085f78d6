// A robot on a surface: floor, shadow, solids, the path of its tip, and names.

class Stage {
  // place(q, frames) is the robot's kernel; notes(stage) draws more on the stage's sheet; least: units
  // that the drawing is wide at least; camera: one that other stages see by too; turned() draws what it sees.
  constructor(canvas, svg, scene, bodies, place, {notes = () => {}, least = 0, camera = new Camera(scene), turned = () => this.draw()} = {}) {
    Object.assign(this, {canvas, svg, scene, place, notes, size: scene.size, path: []});
    this.frames = new Float64Array(FRAME * (bodies + 1));
    this.frames.set([1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0]);
    this.own = this.frames.subarray(FRAME);
    [this.solids, this.camera, this.floor] = [new Solids(scene.solids), camera, new Floor(scene)];
    this.surface = new Surface(canvas, svg, scene, () => this.draw(), least);
    this.resize();
    turnable(canvas, camera, turned);
  }
  get sheet() { return this.surface.sheet; }
  // Fits the view to the canvas; whether that has a size.
  resize() {
    const {surface, camera, canvas} = this;
    if (!surface.resize()) return false;
    if (camera.wide === canvas.width && camera.tall === canvas.height && this.fitted === camera.corners) return true;
    camera.thin = surface.fine;
    camera.fit(canvas.width, canvas.height);
    this.fitted = camera.corners;
    return true;
  }
  // Draws coarser and quicker, or finely again.
  hurry(quick) {
    if (this.surface.quick === quick) return;
    this.surface.quick = quick;
    this.draw();
  }
  // Places of a point of the robot at each of several positions.
  places(positions, point) {
    return positions.map((q) => { this.place(q, this.own); return inWorld(this.frames, point); });
  }
  // Frames all that moves through some positions; larger: how much larger than that the view is.
  frame(positions, larger = 1) {
    const places = positions.flatMap((q) => {
      this.pose(q);
      return this.solids.reach(this.frames);
    });
    const middle = [0, 1, 2].map((k) => places.reduce((sum, place) => sum + place[k], 0) / places.length);
    this.camera.corners = places.map((place) => plus(middle, minus(place, middle), larger));
    this.resize();
  }
  // Widens the first view where the robot has left it.
  widen() {
    const {camera} = this, places = this.solids.reach(this.frames), {wide, tall, scale, middle} = camera;
    if (!places.some((place) => { const [x, y] = camera.seen(place); return x < 0 || y < 0 || x > wide || y > tall; })) return;
    const corners = [...camera.corners, ...places], now = camera.fitting(corners, wide, tall);
    if (now.scale < scale || length(minus(now.middle, middle)) > 0) camera.corners = corners;  // else the view is turned
    this.resize();
  }
  // The place on the sheet of one in the world, and that of one that is fixed in a frame.
  seen(world) { return this.camera.seen(world).slice(0, 2).map((x) => x / this.surface.fine); }
  at(place) { return this.seen(inWorld(this.frames, place)); }
  // A vector of the world on the sheet, metres.
  onSheet(way) { return [dot(way, this.camera.right), -dot(way, this.camera.up)]; }
  // Pixels of the sheet for each metre.
  get scale() { return this.camera.scale * this.camera.zoom / this.surface.fine; }
  pose(q) {
    this.place(q, this.own);
    this.solids.place(this.frames);
  }
  show(q) {
    this.pose(q);
    this.draw();
  }
  draw() {
    if (!this.resize()) return;
    const {surface, camera, scene, floor} = this, {context, raster, colours} = surface;
    surface.begin();
    floor.draw(context, camera, colours, this.solids);
    for (const places of scene.ground) ground(context, this, places, colours);
    surface.paint(this.solids, camera);
    const path = this.path.map((p) => camera.seen(p));
    for (let k = 1; k < path.length; k++) raster.line(path[k - 1], path[k], 0.8 * surface.fine, colours.path);
    for (const [, a, b] of scene.solids) surface.sheet.crowd.clear(this.at(a), this.at(b), 3);
    for (const [css, label, place, way] of scene.names) surface.sheet.want(css, label, both(this.at(place), [way[0], -way[1]]));
    this.notes(this);
    surface.end();
  }
}
