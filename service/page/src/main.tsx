import { render } from "preact";
import "./fonts.css";
import "./style.css";
import "./sign-in.css";
import { App } from "./app";

render(<App />, document.getElementById("page")!);
