// What an example needs besides the soft avatar: a file, a camera, light, a floor, the loop, a ball on the pointer. Nothing of supple.

import * as THREE from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";

/** The bytes of the file that the page's address names: three.html?file=me.glb */
export async function bytes(fallback) {
  const name = new URLSearchParams(location.search).get("file") ?? fallback;
  const response = await fetch(name);
  if (!response.ok) throw new Error(`${name}: ${response.status}; name a file of this server: ?file=me.glb`);
  return response.arrayBuffer();
}

/** A scene that fills the window. */
export function stage() {
  const renderer = new THREE.WebGLRenderer({ antialias: true, preserveDrawingBuffer: true });
  renderer.setPixelRatio(devicePixelRatio);
  renderer.shadowMap.enabled = true;
  document.body.style.margin = 0;
  document.body.append(renderer.domElement);
  const scene = new THREE.Scene();
  scene.background = new THREE.Color(0x26303a);
  const camera = new THREE.PerspectiveCamera(35, 1, 0.01, 100);
  camera.position.set(0, 1.2, 4);
  const controls = new OrbitControls(camera, renderer.domElement);
  controls.target.set(0, 0.95, 0);
  scene.add(new THREE.HemisphereLight(0xffffff, 0x445566, 1.5));
  const sun = new THREE.DirectionalLight(0xffffff, 2.5);
  sun.position.set(1.5, 3, 2.5);
  sun.castShadow = true;
  scene.add(sun);
  const floor = new THREE.Mesh(new THREE.CircleGeometry(2.5, 64), new THREE.MeshStandardMaterial({ color: 0x66727d }));
  floor.rotation.x = -Math.PI / 2;
  floor.receiveShadow = true;
  scene.add(floor);
  const resize = () => {
    renderer.setSize(innerWidth, innerHeight);
    camera.aspect = innerWidth / innerHeight;
    camera.updateProjectionMatrix();
  };
  addEventListener("resize", resize);
  resize();

  /** A mesh that is moved by the pointer while a key is held: where the pointer meets the plane through it. */
  function onPointer(mesh, key = "shiftKey") {
    const [ray, plane, at] = [new THREE.Raycaster(), new THREE.Plane(), new THREE.Vector3()];
    renderer.domElement.addEventListener("pointermove", (event) => {
      if (!event[key]) return;
      const to = new THREE.Vector2((2 * event.clientX) / innerWidth - 1, 1 - (2 * event.clientY) / innerHeight);
      ray.setFromCamera(to, camera);
      plane.setFromNormalAndCoplanarPoint(camera.getWorldDirection(new THREE.Vector3()), mesh.position);
      if (ray.ray.intersectPlane(plane, at)) mesh.position.copy(at);
    });
  }

  /** Calls `update` with the time (s) since the last frame, and draws. */
  function run(update) {
    let last;
    renderer.setAnimationLoop((now) => {
      const dt = last === undefined ? 0 : (now - last) / 1000;
      last = now;
      update(dt);
      controls.update();
      renderer.render(scene, camera);
    });
  }

  return { scene, camera, renderer, controls, onPointer, run };
}

/** A ball to press with. */
export function ball(radius) {
  const mesh = new THREE.Mesh(new THREE.SphereGeometry(radius, 48, 24), new THREE.MeshStandardMaterial({ color: 0x3f8fd0 }));
  mesh.position.set(0, 1.1, 0.8);
  return mesh;
}
