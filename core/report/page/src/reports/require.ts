import { type Describe } from "../page";

export const require: Describe = () => ({ title: "require", sections: [] });
