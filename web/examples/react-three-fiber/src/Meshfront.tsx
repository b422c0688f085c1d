/** A Meshfront model as a component of React Three Fiber. Copy it into your project. */

import { type MeshfrontBudget, type MeshfrontError, type FrameStats, MeshfrontObject } from "@meshfront/three";
import { type ThreeElements, useFrame, useThree } from "@react-three/fiber";
import { useEffect, useLayoutEffect, useRef, useState } from "react";

export type MeshfrontProps = Omit<ThreeElements["mesh"], "args" | "ref" | "geometry"> & {
  /** The address of a `.front` file. */
  src: string;
  /** Pixels that a drawn point may be from where the original surface would be drawn. */
  tolerancePx?: number;
  /** Worker and limits to share with others. */
  budget?: MeshfrontBudget;
  onLoad?: (object: MeshfrontObject) => void;
  onSettled?: (stats: FrameStats) => void;
  onError?: (error: MeshfrontError) => void;
};

/** All other properties, and children such as a material, are those of any mesh. Picking and events work as usual. */
export function Meshfront({ src, tolerancePx = 1, budget, onLoad, onSettled, onError, ...rest }: MeshfrontProps) {
  const [object, setObject] = useState<MeshfrontObject>();
  const invalidate = useThree((state) => state.invalidate);

  const told = useRef({ onLoad, onSettled, onError });
  useLayoutEffect(() => { told.current = { onLoad, onSettled, onError }; });

  useEffect(() => {
    const made = new MeshfrontObject(src, budget ? { budget } : {});
    made.addEventListener("load", () => told.current.onLoad?.(made));
    made.addEventListener("front-settled", ({ stats }) => told.current.onSettled?.(stats));
    made.addEventListener("load-error", ({ error }) => told.current.onError?.(error));
    made.addEventListener("needs-update", () => invalidate());
    setObject(made);
    return () => {
      setObject(undefined);
      made.dispose();
    };
  }, [src, budget, invalidate]);

  useFrame(({ camera, gl }) => {
    if (!object) return;
    object.tolerancePx = tolerancePx;
    object.setResolutionFromRenderer(camera, gl);
    object.update();
  });

  return object ? <primitive object={object} {...rest} /> : null;
}
