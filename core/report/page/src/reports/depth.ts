import { type Describe } from "../page";

export const depth: Describe = () => ({ title: "depth", sections: [] });
