import type { MeshfrontObject } from "@meshfront/three";
import { Canvas, useThree } from "@react-three/fiber";
import { StrictMode, useCallback, useState } from "react";
import { createRoot } from "react-dom/client";
import { Vector3 } from "three";
import { Meshfront } from "./Meshfront";

function Model({ say }: { say: (text: string) => void }) {
  const { camera } = useThree();
  const [picked, setPicked] = useState(false);
  const look = useCallback((object: MeshfrontObject) => {
    const { center, radius } = object.geometry.boundingSphere!;
    camera.position.copy(center).add(new Vector3(0, 0.4, 1.7).multiplyScalar(radius));
    camera.lookAt(center);
  }, [camera]);
  return (
    <Meshfront
      src="model.front"
      onLoad={look}
      onSettled={({ triangles }) => say(`${triangles.toLocaleString()} triangles are drawn`)}
      onError={({ message, remedy }) => say(`${message}. ${remedy}`)}
      onClick={({ point }) => {
        setPicked(!picked);
        say(`Picked ${point.toArray().map((x) => x.toFixed(2)).join(", ")}`);
      }}
    >
      <meshStandardMaterial attach="material" color={picked ? "#c98b5b" : "#d9d0c5"} roughness={0.75} />
    </Meshfront>
  );
}

function App() {
  const [said, say] = useState("Loading …");
  return (
    <>
      <Canvas frameloop="demand" aria-label="A scanned surface" role="img">
        <hemisphereLight args={[0xe4ecf5, 0x3a322c, 0.9]} />
        <directionalLight position={[-0.8, 1, 0.6]} intensity={2.5} />
        <Model say={say} />
      </Canvas>
      <output>{said}</output>
    </>
  );
}

createRoot(document.getElementById("root")!).render(<StrictMode><App /></StrictMode>);
