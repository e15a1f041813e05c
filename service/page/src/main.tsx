import { render } from "preact";
import "./fonts.css";
import "./style.css";
import "./sign-in.css";
import { App } from "./app";
import { enter } from "./session";

// A link of a class may be opened in a window that shows the page already.
enter();
addEventListener("hashchange", enter);

render(<App />, document.getElementById("page")!);
