import { DirectionalLight, HemisphereLight, type PerspectiveCamera, type Scene } from "three";

/**
 * Lights that show the shape of any model. The sky gives shape to what the key light does not reach; the key travels with the
 * camera, so that relief always shows, and a weak light from the other side keeps its shadows open. Adds the camera to the scene.
 */
export function addLights(scene: Scene, camera: PerspectiveCamera): void {
  scene.add(camera, new HemisphereLight(0xe4ecf5, 0x3a322c, 0.85));
  const key = new DirectionalLight(0xfff1e0, 2.5);
  key.position.set(-0.8, 1, 0.6);
  const fill = new DirectionalLight(0xcfe0ff, 0.5);
  fill.position.set(1, -0.2, 0.4);
  for (const light of [key, fill]) {
    light.target.position.set(0, 0, -1);
    camera.add(light, light.target);
  }
}
