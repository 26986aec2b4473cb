import { type Describe } from "../page";

export const trade: Describe = () => ({ title: "trade", sections: [] });
