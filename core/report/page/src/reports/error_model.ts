import { type Describe } from "../page";

export const errorModel: Describe = () => ({ title: "errorModel", sections: [] });
