// The page's beginning: the room is in the folder of the page.
import { openViewer } from "./field/open_viewer";
import { boot } from "./ui/boot";

void boot(document.getElementById("room-page")!, new URL("./", location.href), openViewer);
