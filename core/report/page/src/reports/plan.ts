import { type Describe } from "../page";

export const plan: Describe = () => ({ title: "plan", sections: [] });
