import { type Describe } from "../page";

export const calibration: Describe = () => ({ title: "calibration", sections: [] });
