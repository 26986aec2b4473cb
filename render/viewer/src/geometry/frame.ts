// Raywalk's world and three.js': the one place that converts.
//
// Raywalk's frame is left-handed: x right, y up, z forward. A camera's attitude is
// R_world_from_camera = Ry(yaw) Rx(pitch) Rz(roll): yaw turns to the right, pitch looks up, roll
// turns the camera clockwise. three.js' frame is right-handed with cameras looking along -z, so z
// changes its sign, and with it the sense of yaw and roll.
import { Euler, Matrix4, Quaternion, Vector3 } from "three";

export type Vec3 = [x: number, y: number, z: number];

/** Where the walker's eye is and looks, in Raywalk's frame. */
export interface Pose {
  x_m: number;
  z_m: number;
  /** Above the height at which the room was captured. */
  up_m: number;
  yaw_rad: number;
  pitch_rad: number;
  roll_rad: number;
}

export function threeFromWorld(point: Vec3, out = new Vector3()): Vector3 {
  return out.set(point[0], point[1], -point[2]);
}

export function worldFromThree(point: Vector3): Vec3 {
  return [point.x, point.y, -point.z];
}

export function quaternionOf(pose: Pose, out = new Quaternion()): Quaternion {
  return out.setFromEuler(new Euler(pose.pitch_rad, -pose.yaw_rad, -pose.roll_rad, "YXZ"));
}

export function anglesOf(quaternion: Quaternion): {
  yaw_rad: number;
  pitch_rad: number;
  roll_rad: number;
} {
  const euler = new Euler().setFromQuaternion(quaternion, "YXZ");
  return { yaw_rad: -euler.y, pitch_rad: euler.x, roll_rad: -euler.z };
}

/** The rotation from a three.js camera's axes to Raywalk's world, for shaders: column-major. */
export function worldFromCamera(cameraWorld: Matrix4, out = new Matrix4()): Matrix4 {
  return out.extractRotation(cameraWorld).premultiply(FLIP_Z);
}

const FLIP_Z = new Matrix4().makeScale(1, 1, -1);
